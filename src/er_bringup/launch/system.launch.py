"""The whole graph under ros2 launch: the same nodes and command lines as `er up`.

A parent's PushRosNamespace, SetRemap and SetParameter hold for the whole graph, as if they were arguments. A node that
ends leaves the others running. When the last plant or bridge has done its work, the nodes of this file are ended and
those of a parent go on.
"""

import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from er_bringup.arguments import ARGUMENTS
from er_bringup.given import TOPICS, complete, parse
from er_bringup.graph import NodeSpec, ends_all, nodes
from er_bringup.processes import LAST_PATIENCE, PATIENCE, RESPAWN
from er_model_lab.programs import RECORDER
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, OpaqueFunction
from launch.events import matches_action
from launch.events.process import ProcessExited, ShutdownProcess
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.utilities import prefix_namespace


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
    """The nodes."""
    given = _given(context)
    config = Path(get_package_share_directory("er_bringup")) / "config"
    graph = _Graph(nodes(given, config), respawn=given["respawn"] == "true")
    return list(graph.nodes.values())


def _given(context: LaunchContext) -> dict[str, str]:
    """The arguments, with what a parent has set for all nodes."""
    found = {a.name: LaunchConfiguration(a.name).perform(context) for a in ARGUMENTS}
    # a file that is started by its name, not included: nobody else's arguments are among the command line's
    if Path(__file__).name in (Path(word).name for word in sys.argv):
        parse([word for word in context.argv if not word.startswith("launch-prefix")])
    set_by = context.launch_configurations
    found["namespace"] = prefix_namespace(set_by.get("ros_namespace"), found["namespace"])
    named = [pair.partition("=")[0].strip() for pair in found["remap"].split(",")]
    remaps = dict(set_by.get("ros_remaps") or ())
    pairs = [f"{old}={new}" for old, new in remaps.items() if old in {*TOPICS} - {*named}]
    found["remap"] = ",".join([found["remap"], *pairs])
    single = dict(each for each in set_by.get("global_params") or () if isinstance(each, tuple))
    found["use_sim_time"] = found["use_sim_time"] or single.get("use_sim_time", "").lower()
    return complete(found)


class _Graph:
    """The nodes of this file, and how they end: after the last plant the others, the recorder last of all."""

    def __init__(self, specs: Sequence[NodeSpec], *, respawn: bool) -> None:
        self.respawn = respawn
        self.working = {spec.label for spec in specs if ends_all(spec)}
        self.over = False
        self.nodes = {spec.label: self._node(spec) for spec in specs}
        self.left = {*self.nodes}

    def _node(self, spec: NodeSpec) -> Node:
        again = self.respawn and spec.executable != RECORDER.name
        return Node(
            package=spec.package,
            executable=spec.executable,
            namespace=f"/{spec.namespace.strip('/')}",
            exec_name=spec.label.replace("/", "."),
            arguments=spec.arguments(),
            output="screen",
            respawn=again,
            respawn_delay=RESPAWN,
            sigterm_timeout=str(PATIENCE),
            sigkill_timeout=str(LAST_PATIENCE),
            on_exit=partial(self.ended, spec.label, again),
        )

    def ended(
        self, label: str, again: bool, event: ProcessExited, context: LaunchContext
    ) -> list[EmitEvent] | None:
        """Whom to end after a node has ended; one that a signal ended is no end of the graph."""
        if context.is_shutdown:
            return None  # launch ends them all; a second signal could meet one that is nearly gone
        done = label in self.working and not (event.returncode if again else event.returncode < 0)
        if again and not (done or self.over):
            return None  # launch starts it again
        self.left.discard(label)
        if done:
            self.working.discard(label)
            self.over = not self.working
        ends = (self.left - {RECORDER.name} or self.left) if self.over else set()
        return [
            EmitEvent(event=ShutdownProcess(process_matcher=matches_action(self.nodes[each])))
            for each in sorted(ends | ({label} if again else set()))
        ]
