"""What comes in on a topic: how often, which stamps and values, whether time jumps. For diagnostics; no ROS, no clock.

Times of arrival are seconds of a steady clock, stamps nanoseconds of the node's own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from er_common.stamps import (
    SECOND,
    StampLimits,
    StampState,
    Verdict,
    check_stamp,
    in_order,
    judge,
)

MISSING, LOST = 1.0, 5.0
"""Silence of an input after which it is worth a warning, and after which it is an error [s]."""
REMEMBERED = 1.0
"""How long something that was wrong with a stamp is still said [s]."""
JUMP_REMEMBERED = 5.0
"""How long a jump of time is said [s]."""
SLOW = 0.9
"""Share of the ticks below which an input is too slow."""
BRIDGED = 10
"""Ticks that a sequence number may be ahead and still tell how fast the ticks come: one alone says nothing."""
OFF = 0.1
"""Share of the rate that a node is made for by which samples may come at another one."""
NO_STAMPS = StampState()
OK, WARN, ERROR = 0, 1, 2
"""Levels, those of diagnostic_msgs."""
_CURE = {
    Verdict.STALE: "its publisher or this machine is too slow, or the clock of its machine is off: see max_age",
    Verdict.FUTURE: "synchronise the clocks of the machines (chrony, ptp)",
    Verdict.ZERO: "set header.stamp where it is published",
    Verdict.DUPLICATE: "is it published twice, or played by a bag beside the sensor?",
    Verdict.OUT_OF_ORDER: "is it published twice, or played by a bag beside the sensor?",
}
_WORDS = {
    Verdict.STALE: "too old on arrival",
    Verdict.FUTURE: "ahead of this machine's clock",
    Verdict.ZERO: "without a stamp",
    Verdict.DUPLICATE: "with the stamp of the one before",
    Verdict.OUT_OF_ORDER: "out of order",
}


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing said of an input: level, topic, and a sentence with its cure."""

    level: int
    topic: str
    text: str


@dataclass(slots=True)
class Input:
    """One topic that a node listens to.

    name: as it is called in the graph; limits: when a stamp is bad; since: when the node began [s]; needed:
    whether its absence is a fault; steady: whether every tick of the plant has one, at its own pace; rate: of
    the samples that the node is made for [Hz], 0: any; invalid, non_finite, incomplete: messages whose sender
    called them not valid, others with a number that is none, and others without a part that the node needs.
    """

    name: str
    limits: StampLimits
    since: float
    needed: bool = True
    steady: bool = True
    rate: float = 0.0
    age: float = 0.0
    arrived: float | None = None
    invalid: int = 0
    non_finite: int = 0
    incomplete: int = 0
    _lacks: str = ""
    _lacked: float = -math.inf
    _refused: float = -math.inf
    _strange: float = -math.inf
    _bad: dict[Verdict, float] = field(default_factory=dict)
    _jumped: float | None = None
    _jump: str = ""
    _counted: int = 0
    _looked: float = 0.0
    _measured: float | None = None
    _state: StampState = NO_STAMPS
    _last: int = 0
    _seq: int = 0
    _row: int = 0
    _from: tuple[int, int] = (0, 0)
    _whole: tuple[int, int] = (0, 0)
    _begun: float = 0.0
    _period: float = 0.0

    def note(self, stamp: int, seq: int, arrival: float, now: int | None) -> Verdict:
        """Take one message; now: time of arrival on the clock of the stamps [ns], None where ages mean nothing."""
        if self.arrived is None or arrival - self.arrived >= MISSING:
            self._begun = arrival
        self.arrived = arrival
        if seq == self._seq + 1 and judge(self.limits, self._last, stamp, now) is Verdict.FRESH:
            # nearly always: only counted, until somebody asks
            self._row, self._last, self._seq = self._row + 1, stamp, seq
            return Verdict.FRESH
        before = self.state
        self._state, verdict = check_stamp(self.limits, before, stamp, seq, now)
        self._last, self._seq = self._state[:2]
        near = 0 < before.seq < seq <= before.seq + BRIDGED
        if verdict.use and not (verdict is Verdict.FRESH and near):
            # no mean reaches back over a new beginning, or a number that nobody can have counted to
            self._whole, self._from = self._pace(before.stamp, before.seq), (stamp, seq)
        if verdict in _WORDS:
            self._bad[verdict] = arrival
            self.age = 1e-9 * (now - stamp) if now is not None and stamp else 0.0
        elif verdict in (Verdict.JUMPED_BACK, Verdict.GAP):
            step = (stamp - before.stamp) / SECOND
            self._jumped = arrival
            way = "back" if step < 0.0 else "forward"
            self._jump = f"time jumped {way} by {abs(step):.3g} s: started afresh"
        return verdict

    def read(
        self, numbers: Sequence[float], arrival: float, *, valid: bool, lacks: str = ""
    ) -> None:
        """Look at the values of a message; lacks: a part that it comes without and the node needs."""
        if not valid:
            self.invalid, self._refused = self.invalid + 1, arrival
        elif not math.isfinite(sum(numbers)) and not all(map(math.isfinite, numbers)):
            self.non_finite, self._strange = self.non_finite + 1, arrival
        elif lacks:
            self.incomplete, self._lacks, self._lacked = self.incomplete + 1, lacks, arrival

    def values(self, now: float) -> list[Finding]:
        """What is wrong with its values; empty where all is well. One that need not be there need not be valid."""
        found = []
        if now - self._strange < REMEMBERED:
            text = f"{self.non_finite} messages with NaN or infinite numbers: what does its publisher compute?"
            found.append(Finding(WARN, self.name, text))
        if now - self._refused < REMEMBERED and self.needed:
            text = (
                f"{self.invalid} messages that their sender calls not valid: is its sensor well?"
            )
            found.append(Finding(WARN, self.name, text))
        if now - self._lacked < REMEMBERED:
            text = (
                f"{self.incomplete} messages without {self._lacks}, which this node cannot do without: "
                "does its publisher measure it?"
            )
            found.append(Finding(WARN, self.name, text))
        return found

    @property
    def state(self) -> StampState:
        """Last stamp that was good, and the counts."""
        if self._row:
            self._state = in_order(self._state, self._last, self._seq, self._row)
            self._row = 0
        return self._state

    def measure(self, now: float) -> None:
        """Measure the rate since the last time, and what it should be: once a second or so.

        That is the mean pace of the stamps meanwhile, by the sequence numbers: each stamp alone may be off.
        """
        last = self.state.stamp, self.state.seq
        time, ticks = self._pace(*last)
        if ticks > 0:
            self._period = time / ticks
        self._whole, self._from = (0, 0), last
        if self._looked:
            # of a second in which they began only what came after the first counts
            late = self._begun > self._looked
            count, since = (
                self.state.received - self._counted - late,
                max(self._looked, self._begun),
            )
            self._measured = (
                count / max(now - since, 1e-9) if now - since > 0.5 * MISSING or not late else None
            )
        self._counted, self._looked = self.state.received, now

    def _pace(self, stamp: int, seq: int) -> tuple[int, int]:
        """Time [ns] and ticks that the messages since the last measurement tell of, up to this one."""
        time, ticks = self._whole
        if not self._from[1]:
            return time, ticks
        return time + stamp - self._from[0], ticks + seq - self._from[1]

    @property
    def measured(self) -> float:
        """Rate between the last two measurements [Hz]."""
        return self._measured or 0.0

    def flow(self, now: float) -> Finding:
        """Whether it comes, and as often as it should."""
        silent = now - (self.since if self.arrived is None else self.arrived)
        if silent >= MISSING and self.needed:
            cure = "start its publisher, or remap the topic; ./er doctor shows who is there"
            never = "nothing came" if self.arrived is None else "nothing came any more"
            level = ERROR if silent >= LOST else WARN
            return Finding(level, self.name, f"{never} for {silent:.1f} s: {cure}")
        if silent < MISSING and self._period > 0.0 and self.rate > 0.0:
            pace = SECOND / self._period
            if abs(pace - self.rate) > OFF * self.rate:
                text = f"samples of {pace:.0f} Hz, but this node is made for {self.rate:.0f} Hz: set its parameter rate"
                return Finding(WARN, self.name, text)
        if silent < MISSING and self.steady and self._measured is not None and self._period > 0.0:
            measured, expected = self._measured, SECOND / self._period
            if measured < SLOW * expected:
                text = f"{measured:.0f} Hz of {expected:.0f} Hz arrive: is a CPU or the network overloaded?"
                return Finding(WARN, self.name, text)
        return Finding(OK, self.name, "comes" if silent < MISSING else "not needed, does not come")

    def stamps(self, now: float) -> list[Finding]:
        """What is wrong with its stamps, and whether time jumped; empty where all is well."""
        found = [
            Finding(WARN, self.name, self._sentence(verdict))
            for verdict, when in self._bad.items()
            if now - when < REMEMBERED
        ]
        if self._jumped is not None and now - self._jumped < JUMP_REMEMBERED:
            found.append(Finding(OK, self.name, self._jump))
        return found

    def _sentence(self, verdict: Verdict) -> str:
        word = {Verdict.ZERO: "zero_stamp"}.get(verdict, verdict.value.replace(" ", "_"))
        count = getattr(self.state, word)
        age = (
            f" (the last by {abs(self.age):.3g} s)"
            if verdict in (Verdict.STALE, Verdict.FUTURE)
            else ""
        )
        return f"{count} messages {_WORDS[verdict]}{age}: {_CURE[verdict]}"
