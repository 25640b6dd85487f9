"""Who is ready: the plant begins when every node it waits for says that all its ends are connected.

A publisher that knows of its subscriber is not yet known to it: finding one another takes up to three
seconds each way. So each node looks at its own ends and says in its status whether it is ready.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from time import monotonic

from er_ros_common.managed import NOT_READY, ManagedNode

from er_damper_msgs.msg import NodeStatus
from er_plant_sim.nodes.outlet import Outlet
from er_ros_common import log, topics


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
        """Whether everybody is there, or waiting took longer than the patience [s]."""
        here, missing = self.out.subscribers(), self.missing()
        if (
            not missing
            and self.known()
            and all(n >= m for n, m in zip(here, self.wanted, strict=True))
        ):
            return True
        if monotonic() - self.made_at < self.patience:
            return False
        who = ", ".join(missing) or "everybody"
        log.warning(
            self.node, f"starting without {who}: {here} of {list(self.wanted)} subscribers"
        )
        return True

    def missing(self) -> list[str]:
        """Nodes that are not ready, or not there."""
        return self.roll_call.missing()
