"""Builders from plain values to messages: the only way to publish. What a message is of is read here, too.

A wrong Python type in a field is not refused by ROS 2 Jazzy: a wheel sends garbage, an apt build
aborts. Here a text or None is a TypeError, an integer becomes a number, and a number that is not
finite makes the message invalid (0.0 and ``valid`` false), because NaN never travels.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any, NamedTuple

from er_common.stamps import StampState

from er_damper_msgs.msg import (
    DamperForce,
    FaultEstimate,
    NodeStatus,
    PwmDuty,
    RoadDisplacement,
    SuspensionAcceleration,
    SuspensionDeflection,
)
from er_ros_common.clock import joined, split
from er_ros_common.makers import maker, reader

OK, FAULT = SuspensionDeflection.STATUS_OK, SuspensionDeflection.STATUS_FAULT
NO_STAMPS = StampState()


class _Form(NamedTuple):
    """How messages of a type are made, and the names of their numbers."""

    make: Callable[..., Any]
    numbers: tuple[str, ...]


def _form(kind: type[Any], numbers: tuple[str, ...], more: tuple[str, ...] = ()) -> _Form:
    """Messages with these numbers, and other fields as they are given."""
    return _Form(maker(kind, ("seq", "status", "valid", *numbers, *more)), numbers)


_FACTORS = ("f1", "f2", "f3", "f1_sd", "f2_sd", "f3_sd")
_FACTOR_STATES = ("f1_status", "f2_status", "f3_status")
_RATES = ("output_rate", "step_time_mean", "step_time_max")
_WORDS = ("node", "mode", "reason", "model_id", "gains_id")
_STAMP_COUNTS = (
    "received", "used", "lost", "duplicate", "out_of_order", "stale", "future", "zero_stamp", "resets",
)  # fmt: skip
_COUNTS = (*_STAMP_COUNTS, "non_finite", "invalid", "published", "deadline_misses")
_ACCELERATION = _form(SuspensionAcceleration, ("sprung", "unsprung"))
_DEFLECTION = _form(SuspensionDeflection, ("deflection", "velocity"))
_FORCE = _form(DamperForce, ("force", "force_sd", "test_ratio"))
_ROAD = _form(RoadDisplacement, ("displacement",))
_DUTY = _form(PwmDuty, ("duty",), ("command_seq", "source", "saturated"))
_FAULT = _form(
    FaultEstimate,
    (*_FACTORS, "certainty", "residual", "test_ratio"),
    (*_FACTOR_STATES, "kind", "unexplained"),
)
_STATUS = _form(NodeStatus, _RATES, (*_WORDS, *_COUNTS))


class Tick(NamedTuple):
    """Time of the measurement [ns] and its sequence number, copied from input to output."""

    stamp: int
    seq: int


_PARTS = reader(PwmDuty, ("seq",))
"""Reads the tick of messages of any of our types: these slots have the same names in all of them."""


def tick_of(message: Any) -> Tick:
    """The tick of a message of any of our types; of a recording's reader, too, whose messages have no slots."""
    try:
        sec, nanosec, seq = _PARTS(message)
    except AttributeError:
        stamp = message.header.stamp
        sec, nanosec, seq = stamp.sec, stamp.nanosec, int(message.seq)
    return Tick(joined(sec, nanosec), seq)


def number(name: str, value: Any) -> float:
    """The value as float; TypeError for a text, None, a truth value or anything not real."""
    if type(value) is float:  # nearly always, and the rest is slow
        return value
    if isinstance(value, bool) or not isinstance(value, Real):
        raise TypeError(f"{name} must be a number, not {type(value).__name__}")
    return float(value)


def integer(name: str, value: Any, bits: int) -> int:
    """The value as unsigned integer; TypeError for other types, ValueError beyond the bits."""
    whole = value if type(value) is int else _index(name, value)
    if whole < 0 or whole >> bits:
        raise ValueError(f"{name} must be in 0..2^{bits}-1, not {whole}")
    return whole


def _index(name: str, value: Any) -> int:
    if isinstance(value, bool):
        raise TypeError(f"{name} must be an integer, not bool")
    try:
        return operator.index(value)
    except TypeError:
        raise TypeError(f"{name} must be an integer, not {type(value).__name__}") from None


def truth(name: str, value: Any) -> bool:
    """The value as bool; TypeError for anything but a (NumPy) truth value."""
    if type(value) is bool:
        return value
    if type(value).__name__ in ("bool_", "bool"):
        return bool(value)
    raise TypeError(f"{name} must be true or false, not {type(value).__name__}")


def text(name: str, value: Any) -> str:
    """The value if it is a text, else TypeError."""
    if not isinstance(value, str):
        raise TypeError(f"{name} must be a text, not {type(value).__name__}")
    return value


def suspension_acceleration(
    tick: Tick, sprung: float, unsprung: float, *, status: int = OK, valid: bool = True
) -> SuspensionAcceleration:
    """Accelerations [m/s2], positive upwards, gravity removed."""
    return _made(_ACCELERATION, tick, (sprung, unsprung), status, valid=valid)


def suspension_deflection(
    tick: Tick,
    deflection: float,
    velocity: float | None = None,
    *,
    status: int = OK,
    valid: bool = True,
) -> SuspensionDeflection:
    """Deflection [m], positive in extension, and its velocity [m/s], None where not measured."""
    numbers = (deflection, 0.0 if velocity is None else velocity)
    message = _made(_DEFLECTION, tick, numbers, status, valid=valid)
    message.velocity_valid = message.valid and velocity is not None
    return message


def damper_force(
    tick: Tick,
    force: float,
    *,
    force_sd: float = 0.0,
    test_ratio: float = 0.0,
    status: int = OK,
    valid: bool = True,
) -> DamperForce:
    """Force [N], positive resists extension, its deviation [N], the residual over its gate [1]."""
    return _made(_FORCE, tick, (force, force_sd, test_ratio), status, valid=valid)


def road_displacement(
    tick: Tick, displacement: float, *, status: int = OK, valid: bool = True
) -> RoadDisplacement:
    """Road displacement [m], positive upwards."""
    return _made(_ROAD, tick, (displacement,), status, valid=valid)


def pwm_duty(
    tick: Tick,
    duty: float,
    *,
    command_seq: int | None = None,
    source: int = PwmDuty.SOURCE_UNKNOWN,
    saturated: bool = False,
    status: int = OK,
    valid: bool = True,
) -> PwmDuty:
    """Duty [1], clamped to 0..1 and then marked saturated; command_seq None: it is the command."""
    answered = tick.seq if command_seq is None else integer("command_seq", command_seq, 64)
    more = (answered, integer("source", source, 8), truth("saturated", saturated))
    message = _made(_DUTY, tick, (duty,), status, more, valid=valid)
    if not 0.0 <= message.duty <= 1.0:
        message.duty, message.saturated = min(max(message.duty, 0.0), 1.0), True
    return message


def fault_estimate(
    tick: Tick,
    factors: Sequence[float],
    deviations: Sequence[float],
    states: Sequence[int],
    *,
    kind: int = FaultEstimate.KIND_UNKNOWN,
    certainty: float = 0.0,
    residual: float = 0.0,
    test_ratio: float = 0.0,
    unexplained: bool = False,
    status: int = OK,
    valid: bool = True,
) -> FaultEstimate:
    """Effectiveness f1, f2, f3 [1], their standard deviations [1], a FAULT_* each; which fault, what is left [N]."""
    if not len(factors) == len(deviations) == len(states) == 3:
        raise ValueError("three factors, three standard deviations and three states are needed")
    numbers = (*factors, *deviations, certainty, residual, test_ratio)
    codes = [integer(name, state, 8) for name, state in zip(_FACTOR_STATES, states, strict=True)]
    more = (*codes, integer("kind", kind, 8), truth("unexplained", unexplained))
    return _made(_FAULT, tick, numbers, status, more, valid=valid)


@dataclass(frozen=True, slots=True)
class Timing:
    """Computing: counts since the start; rate [Hz] and step times [s] since the last status."""

    published: int = 0
    deadline_misses: int = 0
    output_rate: float = 0.0
    step_time_mean: float = 0.0
    step_time_max: float = 0.0


NO_TIMING = Timing()


def node_status(
    tick: Tick,
    node: str,
    mode: str,
    *,
    reason: str = "",
    model_id: str = "",
    gains_id: str = "",
    stamps: StampState = NO_STAMPS,
    timing: Timing = NO_TIMING,
    non_finite: int = 0,
    invalid: int = 0,
    status: int = OK,
    valid: bool = True,
) -> NodeStatus:
    """Health of a node; the tick counts the status messages."""
    numbers = tuple(getattr(timing, name) for name in _RATES)
    words = (node, mode, reason, model_id, gains_id)
    counts = [getattr(stamps, name) for name in _STAMP_COUNTS]
    counts += [non_finite, invalid, timing.published, timing.deadline_misses]
    more: list[Any] = [text(name, each) for name, each in zip(_WORDS, words, strict=True)]
    more += [integer(name, each, 64) for name, each in zip(_COUNTS, counts, strict=True)]
    message = _made(_STATUS, tick, numbers, status, more, valid=True)
    message.valid = truth("valid", valid) and message.valid
    return message


def _made(
    form: _Form,
    tick: Tick,
    numbers: Sequence[float],
    status: int,
    more: Sequence[Any] = (),
    *,
    valid: bool,
) -> Any:
    """Message with header, sequence number, numbers, status and validity; zeros when invalid.

    more: its other fields, as they are.
    """
    finite = True
    for value in numbers:
        if type(value) is not float or not math.isfinite(value):  # nearly never
            numbers = [number(*each) for each in zip(form.numbers, numbers, strict=True)]
            finite = all(map(math.isfinite, numbers))
            break
    good = truth("valid", valid) and finite
    if not good:
        numbers = (0.0,) * len(numbers)
    code = integer("status", status, 8)
    if code == OK and not finite:
        code = FAULT
    seq = integer("seq", tick.seq, 64)
    return form.make(*split(tick.stamp), seq, code, good, *numbers, *more)
