"""Who is ready: the plant begins when every node it waits for says that all its ends are connected.

A publisher that knows of its subscriber is not yet known to it: finding one another takes up to three
seconds each way. So each node looks at its own ends and says in its status whether it is ready.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from er_ros_common.managed import NOT_READY, ManagedNode

from er_damper_msgs.msg import NodeStatus
from er_ros_common import topics


class RollCall:
    """Listens to the status of these nodes of the own namespace."""

    def __init__(self, node: ManagedNode, names: Sequence[str]) -> None:
        self._ready = dict.fromkeys(names, False)
        for name in names:
            heard = partial(self._on_status, name)
            node.listen(f"{name}/status", NodeStatus, heard, topics.STATUS.subscriber)

    def _on_status(self, name: str, message: NodeStatus) -> None:
        self._ready[name] = message.mode not in NOT_READY

    def missing(self) -> list[str]:
        """Nodes that are not ready, or not there."""
        return [name for name, ready in self._ready.items() if not ready]
