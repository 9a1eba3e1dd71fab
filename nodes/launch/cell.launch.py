"""Starts the four nodes of the cell, each in a process of its own; they configure and activate themselves."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PythonExpression
from launch_ros.actions import Node


def generate_launch_description():
    arguments = {
        "namespace": ("", "namespace of the cell; two cells in one domain need two"),
        "machine": ("cam_grinder", "machine file, by name or path"),
        "pace": ("realtime", "realtime or fast"),
        "bag_dir": ("", "directory of the bag; empty: one is named"),
        "log_level": ("info", "log level of every node"),
    }

    argument = LaunchConfiguration
    # At pace fast a bag lasts as long as the machine took, not as long as the computer did.
    is_fast = PythonExpression(["'", argument("pace"), "' == 'fast'"])

    def node(name, **parameters):
        return Node(
            package="camwright",
            executable=name,
            name=name,
            namespace=argument("namespace"),
            parameters=[parameters],
            arguments=["--ros-args", "--log-level", argument("log_level")],
        )

    return LaunchDescription(
        [DeclareLaunchArgument(key, default_value=value, description=text) for key, (value, text) in arguments.items()]
        + [
            node("run_logger", bag_dir=argument("bag_dir"), use_sim_time=is_fast),
            node("machine_sim", machine=argument("machine"), pace=argument("pace")),
            node("axis_interpolator"),
            node("job_planner"),
        ]
    )
