# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Starts the four nodes of a cell, each in a process of its own.

    ros2 launch camwright cell.launch.py namespace:=cell1 machine:=lathe job:=turned_cam rviz:=true

What an argument leaves empty is as the parameter file says, and else the node's own default.
"""

import subprocess
from pathlib import Path

from ament_index_python.packages import get_package_prefix
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

PACKAGE = "camwright"

ARGUMENTS = {
    "namespace": ("", "namespace of the cell; two cells in one domain need two"),
    "params_file": ("", "parameters of the nodes; share/camwright/params/nodes.yaml shows all of them"),
    "machine": ("", "machine file, by name or path"),
    "pace": ("", "realtime or fast"),
    "job": ("", "job that runs when a goal names none, by name or path"),
    "bag_dir": ("", "directory of the bag; empty: one is named after the time"),
    "use_sim_time": ("", "true: time is that of /clock; empty: true at pace fast, where the machine publishes it"),
    "log_level": ("info", "log level of every node"),
    "autostart": ("true", "false: the nodes wait for a life cycle manager"),
    "publish_tf": ("true", "false: robot_state_publisher is started and makes the transforms"),
    "respawn": ("false", "true: a node that ends by itself is started again"),
    "page": ("false", "true: the operator page is served"),
    "page_port": ("8080", "its port, on this computer only"),
    "rviz": ("false", "true: RViz is started beside it"),
}


def truth(name, text):
    words = {"true": True, "false": False}
    if text.lower() not in words:
        raise ValueError(f"{name} is {text!r}; allowed: true and false")
    return words[text.lower()]


def processes(context):
    said = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    is_fast = said["pace"] == "fast"
    sim_time = truth("use_sim_time", said["use_sim_time"]) if said["use_sim_time"] else is_fast
    autostart = truth("autostart", said["autostart"])
    publish_tf = truth("publish_tf", said["publish_tf"])
    prefix = Path(get_package_prefix(PACKAGE))

    def given(*names):
        return {name: said[name] for name in names if said[name]}

    def node(executable, parameters=None, package=PACKAGE, name=None, arguments=(), **more):
        own = [said["params_file"]] if said["params_file"] and package == PACKAGE else []
        return Node(
            package=package,
            executable=executable,
            name=name or executable,
            namespace=said["namespace"],
            parameters=own + ([parameters] if parameters else []),
            arguments=list(arguments),
            ros_arguments=["--log-level", said["log_level"]],
            **more,
        )

    def cell_node(executable, **parameters):
        respawn = truth("respawn", said["respawn"])
        parameters["autostart"] = autostart
        return node(executable, parameters, respawn=respawn, respawn_delay=2.0, output="screen")

    # The recorder first, so that the bag begins before anything happens. The machine makes the time and does not read it.
    started = [
        cell_node("run_logger", use_sim_time=sim_time, **given("bag_dir")),
        cell_node("machine_sim", publish_tf=publish_tf, **given("machine", "pace")),
        cell_node("axis_interpolator", use_sim_time=sim_time),
        cell_node("job_planner", use_sim_time=sim_time, **given("job")),
    ]
    if not publish_tf:
        urdf = [str(prefix / "lib" / PACKAGE / "camwright"), "urdf", said["machine"] or "cam_grinder"]
        urdf += ["--namespace", "/" + said["namespace"].strip("/")]
        description = subprocess.run(urdf, check=True, capture_output=True, text=True).stdout
        # The machine publishes its description itself, and again after a dress.
        state_publisher = dict(package="robot_state_publisher", remappings=[("robot_description", "~/robot_description")])
        parameters = {"robot_description": description, "use_sim_time": sim_time}
        started.append(node("robot_state_publisher", parameters, **state_publisher))
    if truth("page", said["page"]):
        # The page is no life cycle node: it only looks.
        started.append(node("camwright", name="operator_page", arguments=["page", "--port", said["page_port"]]))
    if truth("rviz", said["rviz"]):
        config = str(prefix / "share" / PACKAGE / "rviz" / "cell.rviz")
        started.append(node("rviz2", {"use_sim_time": sim_time}, package="rviz2", arguments=["-d", config]))
    return started


def generate_launch_description():
    declared = [DeclareLaunchArgument(name, default_value=value, description=text) for name, (value, text) in ARGUMENTS.items()]
    return LaunchDescription(declared + [OpaqueFunction(function=processes)])
