# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""What real rcl makes of command lines: reads a JSON list of argument lists on stdin, writes a JSON list of verdicts.

Each is asked for a node `talker` in the root namespace. A verdict is "refused", "unknown" (there are tokens that rcl leaves to others,
and rclpy refuses), or what the line changes: the node's name, names of topics and services, parameters that reach the node.
"""

import json
import os
import sys

from rclpy.context import Context
from rclpy.node import Node

PLAIN = {
    "node": "/talker",
    "topics": {"foo": "/foo", "/foo/bar": "/foo/bar", "~/foo": "/talker/foo", "chatter": "/chatter"},
    "services": {"foo": "/foo", "~/foo": "/talker/foo"},
}


def plain(value):
    if isinstance(value, float):
        return f"double {value}"
    if isinstance(value, (list, tuple)) or hasattr(value, "tolist"):
        return [plain(item) for item in value]
    return value


def changed(names, resolve):
    found = {name: resolve(name) for name in names}
    return {name: found[name] for name in names if found[name] != names[name]}


def verdict(arguments):
    context = Context()
    try:
        context.init(args=arguments)
    except Exception as error:  # of which type it is differs from version to version
        return "unknown" if "Unknown" in type(error).__name__ else "refused"
    try:
        node = Node("talker", context=context, start_parameter_services=False, enable_rosout=False,
                    automatically_declare_parameters_from_overrides=True)
        # Every node has these two, given or not.
        own = {"use_sim_time": False, "start_type_description_service": True}
        parameters = {name: parameter.value for name, parameter in node._parameters.items()}
        what = {
            "node": node.get_fully_qualified_name(),
            "topics": changed(PLAIN["topics"], node.resolve_topic_name),
            "services": changed(PLAIN["services"], node.resolve_service_name),
            "parameters": {name: plain(value) for name, value in parameters.items() if own.get(name) != value},
        }
        node.destroy_node()
        return {name: value for name, value in what.items() if value and value != PLAIN["node"]}
    except Exception:
        return "refused"
    finally:
        context.try_shutdown()


def main():
    cases = json.load(sys.stdin)
    # What rcl itself says goes elsewhere.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    json.dump([verdict(case) for case in cases], answers)
    answers.flush()
    os._exit(0)


main()
