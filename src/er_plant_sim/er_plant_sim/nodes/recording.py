"""A recording that the plant waits for, so that it lacks nothing however long its recorder is held up."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import monotonic

from diagnostic_msgs.msg import DiagnosticStatus
from er_ros_common.managed import ManagedNode
from er_ros_common.names import resolved

from er_common import topics
from er_ros_common import log

AHEAD, AHEAD_TICKS = 0.2, 40
"""How far the plant may be ahead of the recording, in time [s], and at least in ticks: so much is on the way."""
PATIENCE = 20.0
"""Longest wait for a topic that is not recorded any further [s]; the middleware takes its recorder for gone by then."""

LONGEST = 20
"""Digits of the largest number of a message; Python refuses to read some thousands of them."""


class Recording:
    """Up to which tick each topic is written.

    names: topics that are followed; changed: called when more is written.
    """

    def __init__(
        self,
        node: ManagedNode,
        recorder: str,
        names: Sequence[str],
        rate: float,
        changed: Callable[[], None],
    ) -> None:
        self.node, self.changed = node, changed
        self.ahead = max(AHEAD_TICKS, round(AHEAD * rate))
        self.written = {resolved(node, name, "recorded"): 0 for name in names}
        self.given_up: set[str] = set()
        self.known, self.since = not recorder, 0.0
        self.warned = False
        self.source = f"{recorder}/recorded" if recorder else ""
        if recorder:
            resolved(node, self.source, "recorder")
            node.listen(self.source, DiagnosticStatus, self.on_said, topics.RECORDED.subscriber)

    def begin(self, tick: int) -> None:
        """Follow from this tick on."""
        self.written = dict.fromkeys(self.written, tick)
        self.given_up, self.since = set(), 0.0

    def on_said(self, message: DiagnosticStatus) -> None:
        """Take what the recorder says."""
        given = {pair.key: pair.value for pair in message.values if pair.key in self.written}
        said = {name: last for name, text in given.items() if (last := _number(text)) is not None}
        if said.keys() != given.keys() and not self.warned:
            self.warned = True
            name = min(given.keys() - said.keys())
            wrong = f"expected a whole number from 0, found {given[name][:20]!r}"
            log.warning(self.node, f"{self.source}: {name}: {wrong}: ignored")
        self.known = True
        if any(last > self.written[name] for name, last in said.items()):
            self.since = 0.0
        self.given_up -= {name for name, last in said.items() if last > self.written[name]}
        self.written.update(said)
        self.changed()

    def follows(self, tick: int, ahead: int | None = None) -> bool:
        """Whether everything up to this tick, but for the last few, is written or will not be."""
        least = tick - (self.ahead if ahead is None else ahead)
        behind = [
            name
            for name, last in self.written.items()
            if last < least and name not in self.given_up
        ]
        if not (behind and self.source and self.known):
            self.since = 0.0
            return True
        now = monotonic()
        self.since = self.since or now
        if self.node.count_publishers(self.source) == 0:
            self._give_up(behind, "there is no recorder any more")
            return True
        if now - self.since > PATIENCE:
            self._give_up(behind, f"nothing was recorded of it for {PATIENCE:g} s")
            return True
        return False

    def _give_up(self, behind: Sequence[str], why: str) -> None:
        """Go on without waiting for these."""
        log.warning(self.node, f"going on without {', '.join(behind)}: {why}")
        self.given_up |= set(behind)
        self.since = 0.0


def _number(text: str) -> int | None:
    """A message's number, a `uint64`; None where the text is none."""
    digits = text.isascii() and text.isdigit() and len(text) <= LONGEST
    return int(text) if digits else None
