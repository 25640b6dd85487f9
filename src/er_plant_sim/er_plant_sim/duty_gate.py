"""The last word on the duty: range, slew and timeout of commands, whatever a controller asks for.

A pure step: ``receive(p, state, command) -> state`` when a command arrives, ``step(p, state, t,
conflict) -> (state, Applied)`` once a tick. Duties that are not finite or not valid are never
taken; a command that is too old is not held: the safe duty takes its place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from er_models.errors import InputError

BURST = 10
"""Commands that one controller may give at once after it was held up: older ones act no more."""


class Reason(Enum):
    """Why the duty is what it is."""

    COMMAND = "command"
    PROGRAM = "program"
    NO_COMMAND = "no command yet"
    OLD_COMMAND = "the last command is too old"
    CONFLICT = "two publishers command the duty"


@dataclass(frozen=True)
class Gate:
    """Limits: duties [1], timeout [s], slew [1/s]; `InputError` when they contradict."""

    duty_min: float
    duty_max: float
    safe_duty: float
    timeout: float
    slew: float = math.inf

    def __post_init__(self) -> None:
        if not 0.0 <= self.duty_min <= self.duty_max <= 1.0:
            found = f"{self.duty_min:g} and {self.duty_max:g}"
            raise InputError(
                "plant", "duty_min, duty_max", "0 <= duty_min <= duty_max <= 1", found
            )
        if not self.duty_min <= self.safe_duty <= self.duty_max:
            expected = (
                f"a duty between duty_min and duty_max ({self.duty_min:g} to {self.duty_max:g})"
            )
            raise InputError("plant", "safe_duty", expected, f"{self.safe_duty:g}")


class Command(NamedTuple):
    """A duty asked for: arrival t [s], seq of the sample it answers (0: unknown), duty, source."""

    t: float
    seq: int
    duty: float
    source: int


class GateState(NamedTuple):
    """Duty in force and since when, the last command taken, and counts.

    repeated: commands more than one a sample; answered: the last number that was answered, newest: the newest sample
    when a command was taken last; ahead: commands by then that answered none of the samples before, 0 to `BURST`.
    """

    duty: float
    t: float
    command: Command | None = None
    refused: int = 0
    limited: int = 0
    repeated: int = 0
    answered: int = 0
    newest: int = 0
    ahead: int = 0


class Applied(NamedTuple):
    """The duty after all limits, and why; command_seq is 0 where no command is in force."""

    duty: float
    command_seq: int
    source: int
    saturated: bool
    reason: Reason


def receive(
    state: GateState, command: Command, *, valid: bool = True, newest: int = 0
) -> GateState:
    """Take a command, unless it is not valid, not finite, or older than the one in force.

    newest: number of the newest sample: one without a number is known to be a second answer only by how many there are.
    """
    late = 0 < command.seq < state.answered
    if not valid or not math.isfinite(command.duty) or late:
        return state._replace(refused=state.refused + 1)
    again = 0 < command.seq == state.answered
    ahead = max(state.ahead - max(newest - state.newest, 0), 0) + (not again)
    duty, t, _, refused, limited, repeated, answered, *_ = state
    repeated += again or ahead > BURST
    counts = (refused, limited, repeated, command.seq or answered, newest, min(ahead, BURST))
    return GateState(duty, t, command, *counts)


def step(
    p: Gate, state: GateState, t: float, *, conflict: bool = False
) -> tuple[GateState, Applied]:
    """Duty in force from time t [s] on; safe without a fresh command from a single publisher."""
    command = state.command
    if conflict:
        return _limited(p, state, t, p.safe_duty, None, Reason.CONFLICT)
    if command is None:
        return _limited(p, state, t, p.safe_duty, None, Reason.NO_COMMAND)
    if t - command.t > p.timeout:
        return _limited(p, state, t, p.safe_duty, None, Reason.OLD_COMMAND)
    return _limited(p, state, t, command.duty, command, Reason.COMMAND)


def program(p: Gate, state: GateState, t: float, duty: float) -> tuple[GateState, Applied]:
    """Duty in force from time t [s] on when it comes from a schedule; the same limits apply."""
    return _limited(p, state, t, duty, None, Reason.PROGRAM)


def _limited(
    p: Gate, state: GateState, t: float, wanted: float, command: Command | None, reason: Reason
) -> tuple[GateState, Applied]:
    """The wanted duty within slew and range."""
    room = math.inf if math.isinf(p.slew) else p.slew * max(t - state.t, 0.0)
    duty = min(max(wanted, state.duty - room), state.duty + room)
    duty = min(max(duty, p.duty_min), p.duty_max)
    saturated = duty != wanted
    _, _, last, refused, limited, *more = state
    state = GateState(duty, t, last, refused, limited + saturated, *more)
    seq, source = (command.seq, command.source) if command else (0, 0)
    return state, Applied(duty, seq, source, saturated, reason)
