"""A car of four corners: how a vehicle's own launch file takes in er_bringup, and a demonstration of it.

    ros2 launch er_bringup vehicle.launch.py                 # bumps under all four wheels, 20 s
    ros2 launch er_bringup vehicle.launch.py duration:=0     # until Ctrl-C

What is set around an include holds for every node of it: the namespace here, in your own file also SetRemap and
SetParameter. Copy it and leave out what your vehicle has itself; hardware:=stack takes its sensors.
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    IncludeLaunchDescription,
    OpaqueFunction,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import PushRosNamespace
from launch_ros.substitutions import FindPackageShare

CORNERS = ("front_left", "front_right", "rear_left", "rear_right")
SYSTEM = PathJoinSubstitution([FindPackageShare("er_bringup"), "launch", "system.launch.py"])


def generate_launch_description() -> LaunchDescription:
    """The corners, each in its own namespace."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("duration", default_value="20", description="[s]; 0: no end"),
            DeclareLaunchArgument("seed", default_value="1", description="of the first corner"),
            DeclareLaunchArgument("observers", default_value="unified", description="or none"),
            PushRosNamespace("vehicle/suspension"),
            OpaqueFunction(function=_corners),
        ]
    )


def _corners(context: LaunchContext) -> list[GroupAction]:
    """One include for each corner; a composed corner is one process."""
    seed = int(LaunchConfiguration("seed").perform(context))
    return [
        GroupAction(
            [
                PushRosNamespace(corner),
                IncludeLaunchDescription(
                    PythonLaunchDescriptionSource(SYSTEM),
                    launch_arguments={
                        "program": "bumps",
                        "composed": "true",
                        "observers": LaunchConfiguration("observers"),
                        "duration": LaunchConfiguration("duration"),
                        "seed": str(seed + place),
                    }.items(),
                ),
            ]
        )
        for place, corner in enumerate(CORNERS)
    ]
