"""From commands on the wire to those of the duty gate: which sample each answers, and whether it may act. No clock.

A command names the sample that it answers by `stamp` and `seq`, both copied from it. The stamp must be set and on the
clock of the samples; whoever writes its own time there instead says that it answers what is measured now. `seq` says
more exactly which sample it was; 0 leaves it to the stamp.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from er_common.stamps import (
    RENUMBERED,
    SECOND,
    StampLimits,
    StampState,
    check_stamp,
    judge,
)
from er_ros_common.builders import Tick, tick_of

from er_damper_msgs.msg import PwmDuty
from er_plant_sim.duty_gate import Command


class Commands(NamedTuple):
    """What was counted of the commands since the start, as in NodeStatus."""

    stamps: StampState = StampState()
    invalid: int = 0


class Answer(NamedTuple):
    """The sample that a command answers.

    behind: how much older it is than the newest one, by its stamp [ns]; seq: its number, 0 where it is not known.
    """

    behind: int
    seq: int


def judged(
    limits: StampLimits, state: Commands, message: PwmDuty, last: Tick, now: int
) -> tuple[Commands, Answer | None]:
    """The sample that a command answers, None where its stamp is bad; bad ones are counted.

    Args:
        limits: greatest age, and greatest lead over the clock.
        state: counts so far.
        message: the command.
        last: the newest sample.
        now: time on the clock of the samples [ns].
    """
    stamp, seq = tick_of(message)
    # as if no stamp came before: order, and two answers to one sample, are the gate's concern
    if not judge(limits, 0, stamp, now).use:
        counted, _ = check_stamp(limits, state.stamps._replace(stamp=0), stamp, seq, now)
        return state._replace(stamps=counted), None
    if seq > last.seq:
        seq = 0  # it was meant for a plant that was here before
    if not seq and stamp == last.stamp:
        seq = last.seq
    return state, Answer(last.stamp - min(stamp, now), seq)


def passed_on(state: Commands, message: PwmDuty, seq: int, *, refused: bool) -> Commands:
    """Count a command with a good stamp after the duty gate had it; refused: whether it did not take it."""
    stamps, received = state.stamps, state.stamps.received + 1
    if not message.valid:
        return Commands(stamps._replace(received=received), state.invalid + 1)
    if refused:
        late = stamps.out_of_order + math.isfinite(message.duty)
        return Commands(stamps._replace(received=received, out_of_order=late), state.invalid)
    ahead = seq - stamps.seq if seq and stamps.seq else 0
    lost = stamps.lost + (ahead - 1 if 1 < ahead <= RENUMBERED else 0)
    last, used = seq or stamps.seq, stamps.used + 1
    stamps = stamps._replace(seq=last, received=received, used=used, lost=lost)
    return Commands(stamps, state.invalid)


def command(message: PwmDuty, answer: Answer, last: Tick, dt: float) -> Command:
    """A command of the gate, as old as the sample it answers; samples are dt [s] apart, number 0 is at 0 s."""
    at = last.seq * dt - answer.behind / SECOND
    if answer.seq and answer.seq * dt - at < 0.5 * dt:
        at = answer.seq * dt
    return Command(at, answer.seq, float(message.duty), int(message.source))
