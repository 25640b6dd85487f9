"""Builders from plain values to messages: the only way to publish.

A wrong Python type in a field is not refused by ROS 2 Jazzy: a wheel sends garbage, an apt build
aborts. Here a text or None is a TypeError, an integer becomes a number, and a number that is not
finite makes the message invalid (0.0 and ``valid`` false), because NaN never travels.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any, TypeVar

from er_damper_msgs.msg import (
    DamperForce,
    FaultEstimate,
    NodeStatus,
    PwmDuty,
    RoadDisplacement,
    SuspensionAcceleration,
    SuspensionDeflection,
)
from er_ros_common.blank import blank
from er_ros_common.clock import set_stamp
from er_ros_common.stamps import StampState

OK, FAULT = SuspensionDeflection.STATUS_OK, SuspensionDeflection.STATUS_FAULT
NO_STAMPS = StampState()
M = TypeVar("M")
_FACTORS = ("f1", "f2", "f3", "f1_sd", "f2_sd", "f3_sd")
_FACTOR_STATES = ("f1_status", "f2_status", "f3_status")


@dataclass(frozen=True, slots=True)
class Tick:
    """Time of the measurement [ns] and its sequence number, copied from input to output."""

    stamp: int
    seq: int


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
    if isinstance(value, bool) or type(value).__name__ in ("bool_", "bool"):
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
    numbers = {"sprung": sprung, "unsprung": unsprung}
    return _filled(blank(SuspensionAcceleration), tick, numbers, status, valid=valid)


def suspension_deflection(
    tick: Tick,
    deflection: float,
    velocity: float | None = None,
    *,
    status: int = OK,
    valid: bool = True,
) -> SuspensionDeflection:
    """Deflection [m], positive in extension, and its velocity [m/s], None where not measured."""
    numbers = {"deflection": deflection, "velocity": 0.0 if velocity is None else velocity}
    message = _filled(blank(SuspensionDeflection), tick, numbers, status, valid=valid)
    message.velocity_valid = bool(message.valid and velocity is not None)
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
    numbers = {"force": force, "force_sd": force_sd, "test_ratio": test_ratio}
    return _filled(blank(DamperForce), tick, numbers, status, valid=valid)


def road_displacement(
    tick: Tick, displacement: float, *, status: int = OK, valid: bool = True
) -> RoadDisplacement:
    """Road displacement [m], positive upwards."""
    return _filled(
        blank(RoadDisplacement), tick, {"displacement": displacement}, status, valid=valid
    )


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
    message = _filled(blank(PwmDuty), tick, {"duty": duty}, status, valid=valid)
    wanted = message.duty
    message.duty = min(max(wanted, 0.0), 1.0)
    message.saturated = truth("saturated", saturated) or message.duty != wanted
    message.command_seq = (
        tick.seq if command_seq is None else integer("command_seq", command_seq, 64)
    )
    message.source = integer("source", source, 8)
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
    numbers = dict(zip(_FACTORS, (*factors, *deviations), strict=True))
    numbers |= {"certainty": certainty, "residual": residual, "test_ratio": test_ratio}
    message = _filled(blank(FaultEstimate), tick, numbers, status, valid=valid)
    message.kind = integer("kind", kind, 8)
    message.unexplained = truth("unexplained", unexplained)
    for name, state in zip(_FACTOR_STATES, states, strict=True):
        setattr(message, name, integer(name, state, 8))
    return message


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
    rates = ("output_rate", "step_time_mean", "step_time_max")
    numbers = {name: getattr(timing, name) for name in rates}
    message = _filled(blank(NodeStatus), tick, numbers, status, valid=True)
    message.valid = truth("valid", valid) and message.valid
    texts = {
        "node": node,
        "mode": mode,
        "reason": reason,
        "model_id": model_id,
        "gains_id": gains_id,
    }
    for name, words in texts.items():
        setattr(message, name, text(name, words))
    for name in ("received", "used", "lost", "duplicate", "out_of_order", "stale", "future"):
        setattr(message, name, integer(name, getattr(stamps, name), 64))
    message.zero_stamp, message.resets = int(stamps.zero_stamp), int(stamps.resets)
    counts = {"non_finite": non_finite, "invalid": invalid, "published": timing.published}
    for name, value in (counts | {"deadline_misses": timing.deadline_misses}).items():
        setattr(message, name, integer(name, value, 64))
    return message


def _filled(message: M, tick: Tick, numbers: dict[str, Any], status: int, *, valid: bool) -> M:
    """Message with header, sequence number, numbers, status and validity; zeros when invalid."""
    target: Any = message
    good, finite = truth("valid", valid), True
    for name, value in numbers.items():
        each = number(name, value)
        finite = finite and math.isfinite(each)
        setattr(target, name, each)
    code = integer("status", status, 8)
    set_stamp(target.header.stamp, tick.stamp)
    target.seq = integer("seq", tick.seq, 64)
    if not (good and finite):
        for name in numbers:
            setattr(target, name, 0.0)
    target.status = FAULT if not finite and code == OK else code
    target.valid = good and finite
    return message
