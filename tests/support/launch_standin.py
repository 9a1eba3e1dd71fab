# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Tells what a launch file would start, without ROS 2's launch: that is on no package index for Python.

    launch_standin.py FILE [name:=value ...]

The few classes that the file imports from `launch` and `launch_ros` are stand-ins here. Each process is one line of JSON: its command
line as launch_ros makes it, and whether it is started again. It is not ROS 2's launch: what that would refuse may pass here.
"""

import importlib.util
import json
import sys
import types
from pathlib import Path

from ament_index_python.packages import get_package_prefix


class LaunchDescription(list):
    pass


class DeclareLaunchArgument:
    def __init__(self, name, *, default_value=None, description=None):
        assert description, f"argument {name} has no description"
        assert isinstance(default_value, str), f"the default of {name} is no text"
        self.name, self.default_value = name, default_value


class LaunchConfiguration:
    def __init__(self, name):
        self.name = name

    def perform(self, context):
        return context[self.name]


class OpaqueFunction:
    def __init__(self, *, function):
        self.function = function


def text(value):
    return str(value).lower() if isinstance(value, bool) else str(value)


class Node:
    def __init__(self, *, package, executable, name, namespace, parameters, arguments, ros_arguments, remappings=(),
                 respawn=False, respawn_delay=None, output="log"):
        self.respawn = respawn
        binary = Path(package) / executable
        if package == "camwright":
            binary = Path(get_package_prefix(package)) / "lib" / package / executable
            assert binary.is_file(), f"{binary} is not there"
        self.command = [str(binary), *arguments, "--ros-args", *ros_arguments, "-r", f"__node:={name}"]
        if namespace:
            self.command += ["-r", f"__ns:=/{namespace.strip('/')}"]
        for entry in parameters:
            if isinstance(entry, str):
                self.command += ["--params-file", entry]
            else:
                # launch_ros writes a file; the values are the same.
                for key, value in entry.items():
                    self.command += ["-p", f"{key}:={text(value)}"]
        for before, after in remappings:
            self.command += ["-r", f"{before}:={after}"]


def module(name, **members):
    made = types.ModuleType(name)
    vars(made).update(members)
    sys.modules[name] = made


def main():
    module("launch", LaunchDescription=LaunchDescription)
    module("launch.actions", DeclareLaunchArgument=DeclareLaunchArgument, OpaqueFunction=OpaqueFunction)
    module("launch.substitutions", LaunchConfiguration=LaunchConfiguration)
    module("launch_ros")
    module("launch_ros.actions", Node=Node)
    spec = importlib.util.spec_from_file_location("launch_file", sys.argv[1])
    file = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(file)
    description = file.generate_launch_description()
    context = {entry.name: entry.default_value for entry in description if isinstance(entry, DeclareLaunchArgument)}
    for argument in sys.argv[2:]:
        name, value = argument.split(":=", 1)
        assert name in context, f"there is no argument {name}"
        context[name] = value
    for entry in description:
        for node in entry.function(context) if isinstance(entry, OpaqueFunction) else []:
            print(json.dumps({"command": node.command, "respawn": node.respawn}))


main()
