"""Checks of incoming stamps: what to use, to drop, when to start over. The clock is an input."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Final, NamedTuple

SECOND: Final = 1_000_000_000
"""Nanoseconds of a second: the unit of every stamp."""
RENUMBERED = 1_000_000
"""Step of the sequence number from which on it is no loss: somebody counts anew, or sends nonsense."""


class Verdict(Enum):
    """What a stamp means for the sample and for the state carried over from the one before.

    use: whether the sample may be used; restart: whether a state carried over from the sample before is void;
    carries: whether the numbers between the two samples are losses.
    """

    FRESH = "fresh"
    FIRST = "first"
    GAP = "gap"
    JUMPED_BACK = "jumped back"
    DUPLICATE = "duplicate"
    OUT_OF_ORDER = "out of order"
    STALE = "stale"
    FUTURE = "future"
    ZERO = "zero"

    def __init__(self, word: str) -> None:
        self.use = word in ("fresh", "first", "gap", "jumped back")
        self.restart = word in ("first", "gap", "jumped back")
        self.carries = word in ("fresh", "gap")


@dataclass(frozen=True, slots=True)
class StampLimits:
    """When a stamp is refused.

    Attributes:
        stale: greatest age on arrival [s].
        future: greatest lead over the clock [s].
        gap: longest step that a state may be carried over [s]; 10 periods at 200 Hz.
        back: a stamp older than the last one by more than this [s] is a restart of time (a bag
            that loops, a simulation that was reset), by less it is a straggler.
        whole: the same four in nanoseconds.
    """

    stale: float = 0.020
    future: float = 0.005
    gap: float = 0.050
    back: float = 0.5
    whole: tuple[int, int, int, int] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        each = (self.stale, self.future, self.gap, self.back)
        object.__setattr__(self, "whole", tuple(round(seconds * SECOND) for seconds in each))


CLOCK_STEP = round(0.5 * StampLimits().future * SECOND)
"""Difference between the system clock and stamps made with a steady one beyond which the stamps follow [ns].

Half of the lead at which they are refused: no step is so small that the stamps stay and are refused for it.
"""


class StampState(NamedTuple):
    """Last accepted stamp [ns] and sequence number, and the counts since the start."""

    stamp: int = 0
    seq: int = 0
    received: int = 0
    used: int = 0
    lost: int = 0
    duplicate: int = 0
    out_of_order: int = 0
    stale: int = 0
    future: int = 0
    zero_stamp: int = 0
    resets: int = 0


_NEW = tuple.__new__
_FRESH = Verdict.FRESH  # a member costs four times as much by the name of its class
_COUNTER = {
    Verdict.DUPLICATE: "duplicate",
    Verdict.OUT_OF_ORDER: "out_of_order",
    Verdict.STALE: "stale",
    Verdict.FUTURE: "future",
    Verdict.ZERO: "zero_stamp",
}


def check_stamp(
    limits: StampLimits, state: StampState, stamp: int, seq: int = 0, now: int | None = None
) -> tuple[StampState, Verdict]:
    """Judge one stamp.

    Args:
        limits: when to refuse.
        state: after the message before; `StampState()` at the start.
        stamp: of the message [ns].
        seq: of the message; 0 when it has none.
        now: time of arrival on the same clock [ns]; None where age means nothing, as in a bag.

    Returns:
        The next state and the verdict. A refused sample changes nothing but the counts.
    """
    verdict = judge(limits, state.stamp, stamp, now)
    if verdict is _FRESH and seq == state.seq + 1:  # nearly always
        return _NEW(StampState, (stamp, seq, state[2] + 1, state[3] + 1, *state[4:])), verdict
    if not verdict.use:
        name = _COUNTER[verdict]
        counts = {"received": state.received + 1, name: getattr(state, name) + 1}
        return state._replace(**counts), verdict
    step = seq - state.seq if state.seq and verdict.carries else 0
    following = state._replace(
        stamp=stamp,
        seq=seq,
        received=state.received + 1,
        used=state.used + 1,
        lost=state.lost + (step - 1 if 1 < step <= RENUMBERED else 0),
        resets=state.resets + (verdict.restart and verdict is not Verdict.FIRST),
    )
    return following, verdict


Checks = tuple[StampState, ...]
"""What is known of the stamps of several inputs, one for each."""


def check_input(
    limits: Sequence[StampLimits],
    states: Checks,
    which: int,
    stamp: int,
    seq: int = 0,
    now: int | None = None,
) -> tuple[Checks, Verdict]:
    """Judge a stamp of one of several inputs, each by its own limits and its own past; see `check_stamp`."""
    after = list(states)
    after[which], verdict = check_stamp(limits[which], states[which], stamp, seq, now)
    return tuple(after), verdict


def counted(states: Checks) -> StampState:
    """The counts of all inputs together; stamp, sequence number and resets are those of the first."""
    sums = [sum(each) for each in zip(*(state[2:-1] for state in states), strict=True)]
    first = states[0]
    return StampState._make((first.stamp, first.seq, *sums, first.resets))


def in_order(state: StampState, stamp: int, seq: int, number: int) -> StampState:
    """The state after so many fresh messages without a loss, the last one with this stamp [ns] and sequence number."""
    received, used = state.received + number, state.used + number
    return state._replace(stamp=stamp, seq=seq, received=received, used=used)


def judge(limits: StampLimits, last: int, stamp: int, now: int | None) -> Verdict:
    """What a stamp means; all in ns. last: the one that was used before, 0 where none was; now: see `check_stamp`."""
    stale, future, gap, back = limits.whole
    if stamp <= 0:
        return Verdict.ZERO
    if now is not None:
        age = now - stamp
        if -age > future:
            return Verdict.FUTURE
        if age > stale:
            return Verdict.STALE
    if not last:
        return Verdict.FIRST
    step = stamp - last
    if step > 0:
        return Verdict.GAP if step > gap else _FRESH
    if step == 0:
        return Verdict.DUPLICATE
    return Verdict.JUMPED_BACK if -step > back else Verdict.OUT_OF_ORDER
