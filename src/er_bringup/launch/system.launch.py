"""The whole graph under ros2 launch: the same nodes and command lines as `er up`."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from er_bringup.arguments import ARGUMENTS
from er_bringup.given import complete
from er_bringup.graph import ends_all, nodes
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """Arguments, and the nodes they ask for."""
    declared = [
        DeclareLaunchArgument(
            a.name,
            default_value=a.default,
            description=a.meaning,
            **({"choices": list(a.choices)} if a.choices else {}),
        )
        for a in ARGUMENTS
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=_start)])


def _start(context: LaunchContext) -> list[Node]:
    """The nodes; the end of the last plant, of one in each corner, is the end of all."""
    given = complete({a.name: LaunchConfiguration(a.name).perform(context) for a in ARGUMENTS})
    config = Path(get_package_share_directory("er_bringup")) / "config"
    specs = nodes(given, config)
    left = [spec.label for spec in specs if ends_all(spec)]

    def ended(_: LaunchContext, label: str) -> list[Shutdown]:
        left.remove(label)
        return [] if left else [Shutdown()]

    return [
        Node(
            package=spec.package,
            executable=spec.executable,
            arguments=spec.arguments(),
            output="screen",
            on_exit=[OpaqueFunction(function=ended, args=[spec.label])] if ends_all(spec) else [],
        )
        for spec in specs
    ]
