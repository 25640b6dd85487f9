r"""Two-state Skyhook control of a semi-active damper, thesis (3.81).

.. math::  u = u_{max} \text{ if } \dot z_s \dot z_{def} \ge 0 \text{ else } u_{min}

The damper can only resist the deflection velocity. Where that velocity has the sign of the
absolute velocity of the sprung mass, resisting brakes the body: full field. Otherwise it would
push the body on: least field.

The absolute velocity is not measured. It is the leaky integral of the sprung acceleration,

.. math::  \dot{\hat v}_s = \ddot z_s - \omega_c \hat v_s, \qquad \omega_c = 2 \pi f_c,

integrated exactly for an acceleration that is linear between the samples. The leak forgets a wrong
start and bounds what an accelerometer bias b can do to b / omega_c. Its price is a phase lead of
atan(f_c / f): with f_c = 0.1 Hz that is 1.4 degrees at the body resonance of 4 Hz, and a bias of
0.025 m/s2 ends as 0.04 m/s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

from er_models.errors import InputError
from er_models.model import Array

N = TypeVar("N", float, Array)


@dataclass(frozen=True)
class Skyhook:
    """Duties [1], corner frequency of the leaky integral [Hz], longest bridged gap [s]."""

    u_min: float
    u_max: float
    corner_frequency: float
    gap: float = 0.05

    def __post_init__(self) -> None:
        if not 0.0 <= self.u_min <= self.u_max <= 1.0:
            found = f"{self.u_min:g} and {self.u_max:g}"
            raise InputError(
                "skyhook_controller", "u_min, u_max", "0 <= u_min <= u_max <= 1", found
            )
        if not self.corner_frequency > 0.0:
            found = f"{self.corner_frequency:g}"
            raise InputError(
                "skyhook_controller", "corner_frequency", "a frequency above 0 Hz", found
            )


class Sample(NamedTuple):
    """Time of measurement [s], sprung acceleration [m/s2], deflection velocity [m/s]."""

    t: float
    sprung_acceleration: float
    deflection_velocity: float


class State(NamedTuple):
    """Absolute velocity of the sprung mass [m/s], the last sample, restarts of the integral."""

    velocity: float = 0.0
    last: Sample | None = None
    resets: int = 0


class Command(NamedTuple):
    """Duty [1] and the velocity [m/s] it was decided with."""

    duty: float
    sprung_velocity: float


START = State()
LARGEST = (200.0, 20.0)
"""Largest believable acceleration of a body [m/s2] and velocity of its damper [m/s]: twenty g."""


def step(p: Skyhook, state: State, sample: Sample) -> tuple[State, Command]:
    """Duty for a sample; after a gap, or when time runs back, the integral starts anew from zero.

    The sample must be `usable`.
    """
    last = state.last
    if last is None:
        state = State(0.0, sample, state.resets)
    elif not 0.0 < sample.t - last.t <= p.gap:
        state = State(0.0, sample, state.resets + 1)
    else:
        a0, a1 = last.sprung_acceleration, sample.sprung_acceleration
        velocity = leaky(p.corner_frequency, sample.t - last.t, state.velocity, a0, a1)
        state = State(velocity, sample, state.resets)
    brakes_body = state.velocity * sample.deflection_velocity >= 0.0
    return state, Command(p.u_max if brakes_body else p.u_min, state.velocity)


def usable(sample: Sample) -> bool:
    """Whether all values are finite and believable."""
    _, acceleration, velocity = sample
    believable = abs(acceleration) <= LARGEST[0] and abs(velocity) <= LARGEST[1]
    return math.isfinite(sample.t) and believable


def leaky(frequency: float, h: float, velocity: N, a0: N, a1: N) -> N:
    """Leaky integral h [s] later, exact for an acceleration in a line from a0 to a1; frequency: its corner [Hz]."""
    w = 2.0 * math.pi * frequency
    decay = math.exp(-w * h)
    mean = -math.expm1(-w * h) / w
    slope = (h - mean) / w
    return decay * velocity + a0 * mean + (a1 - a0) / h * slope
