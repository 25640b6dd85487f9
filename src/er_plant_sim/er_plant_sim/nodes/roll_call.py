"""Who is ready: the plant begins when every node it waits for says that all its ends are connected.

A publisher that knows of its subscriber is not yet known to it: finding one another takes up to three
seconds each way. So each node looks at its own ends and says in its status whether it is ready.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from time import monotonic

from er_ros_common.managed import NOT_READY, ManagedNode
from er_ros_common.names import resolved

from er_common import topics
from er_damper_msgs.msg import NodeStatus
from er_plant_sim.nodes.outlet import Outlet
from er_ros_common import log

COMPILING = 3.0
"""So many times longer a node is waited for that is there and has not said anything yet: it compiles what is new or has
changed, which takes a minute and more on a busy machine."""


class RollCall:
    """Listens to the status of these nodes of the own namespace."""

    def __init__(self, node: ManagedNode, names: Sequence[str]) -> None:
        self._node = node
        self._ready: dict[str, bool | None] = dict.fromkeys(names)
        for name in names:
            resolved(node, f"{name}/status", "wait_for_nodes")
            heard = partial(self._on_status, name)
            node.listen(f"{name}/status", NodeStatus, heard, topics.STATUS.subscriber)

    def _on_status(self, name: str, message: NodeStatus) -> None:
        self._ready[name] = message.mode not in NOT_READY

    def missing(self) -> list[str]:
        """Nodes that are not ready, or not there."""
        return [name for name, ready in self._ready.items() if not ready]

    def coming(self) -> list[str]:
        """Nodes that are there and have not said anything yet."""
        silent = [name for name, ready in self._ready.items() if ready is None]
        return [name for name in silent if self._node.count_publishers(f"{name}/status")]


class Gathering:
    """Waits until the graph is complete: nodes that are ready, and subscribers of every topic.

    known: whether what else has to be heard first was.
    """

    def __init__(
        self,
        node: ManagedNode,
        out: Outlet,
        wanted: Sequence[int],
        names: Sequence[str],
        patience: float,
        known: Callable[[], bool] = lambda: True,
    ) -> None:
        self.node, self.out, self.wanted, self.patience = node, out, wanted, patience
        self.roll_call, self.made_at, self.known = RollCall(node, names), monotonic(), known

    def begin(self) -> None:
        """Wait anew."""
        self.made_at = monotonic()

    def complete(self) -> bool:
        """Whether everybody is there, or waiting took longer than the patience [s]; who compiles is waited for."""
        here, missing = self.out.subscribers(), self.roll_call.missing()
        if (
            not missing
            and self.known()
            and all(n >= m for n, m in zip(here, self.wanted, strict=True))
        ):
            return True
        waited = monotonic() - self.made_at
        if waited < self.patience or (
            waited < COMPILING * self.patience and self.roll_call.coming()
        ):
            return False
        who = ", ".join(missing) or "everybody"
        log.warning(
            self.node, f"starting without {who}: {here} of {list(self.wanted)} subscribers"
        )
        return True

    def missing(self) -> list[str]:
        """Nodes that are not ready, or not there, in words."""
        coming = self.roll_call.coming()
        return [f"{n} (still compiling)" if n in coming else n for n in self.roll_call.missing()]
