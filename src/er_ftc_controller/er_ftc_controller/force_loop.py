r"""From force to duty: an inner loop on the field's own subsystem (2.10), with an estimated force.

.. math::  \tau \dot F_{er} + F_{er} = f_1 f_2 f_3\, \sigma u^\beta s, \qquad
           \sigma u^\beta s f_1 f_2 f_3 = \frac{F_{er}^* - k \hat F_{er}}{1 - k}, \quad k = e^{-h / \tau}

The yield force is followed by the model, from the duty that acted, and drawn towards an estimated force where there is
one. The duty is the one that would bring it to what is wanted within the horizon h, the motion held. With tau = 0, or
an endless horizon, it is the inverse static model of the thesis. There is no integral that could wind up: the model
is told the duty as it was limited.

Source: thesis (2.10), (6.8), end of 6.4; the sign is that of the deflection velocity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from er_models.errors import InputError
from er_models.forms.loss import Factors
from er_models.static_damper import StaticDamper

from er_ftc_controller.schedule import kept_after, respond


@dataclass(frozen=True)
class ForceLoop:
    """Static damper and its response time tau [s]; limits of the duty, its fastest change [1/s], its dead zone.

    horizon: within which the force is to be reached [s], infinite for the inverse static model. correction: share of
    the difference to an estimated force that is taken over at each sample.
    dead_zone: duties below it are the least one, counted by what an electrical fault leaves of their field: a weak
    field is no reason to act more often. least_gate: a smaller |s| is taken for it, since what no duty can make must
    not ask for all of it.
    """

    damper: StaticDamper
    tau: float
    duties: tuple[float, float]
    horizon: float = 0.01
    correction: float = 0.0
    slew: float = math.inf
    dead_zone: float = 0.0
    least_gate: float = 0.4

    def __post_init__(self) -> None:
        low, high = self.duties
        checks = (
            ("tau", self.tau, 0.0 <= self.tau < math.inf, "a time of 0 s or more"),
            ("horizon", self.horizon, self.horizon > 0.0, "a time above 0 s"),
            ("correction", self.correction, 0.0 <= self.correction <= 1.0, "a share, 0 to 1"),
            ("slew", self.slew, self.slew > 0.0, "a rate above 0 1/s"),
            ("dead_zone", self.dead_zone, 0.0 <= self.dead_zone < 1.0, "a duty below 1"),
            ("least_gate", self.least_gate, 0.0 <= self.least_gate < 1.0, "0 to less than 1"),
            ("duties", self.duties, 0.0 <= low <= high <= 1.0, "0 <= low <= high <= 1"),
        )
        for name, value, holds, expected in checks:
            if not holds:
                raise InputError("force loop", name, expected, value)


class LoopState(NamedTuple):
    """Yield force [N] as (6.8) counts it, gate s of the last sample, duty asked for last [1]."""

    force: float = 0.0
    gate: float = 0.0
    duty: float = 0.0


class Motion(NamedTuple):
    """Deflection [m], its velocity [m/s], estimated damper force [N] (NaN: none), duty that acted (else: as asked)."""

    x: float
    v: float
    force: float = math.nan
    duty: float = math.nan


def balance(m_s: float, k_s: float, acceleration: float, x: float) -> float:
    """Damper force [N] that the body's acceleration [m/s2] and deflection [m] tell, whatever the damper: (2.1)."""
    return -m_s * acceleration - k_s * x


def follow(p: ForceLoop, state: LoopState, m: Motion, dt: float, left: Factors) -> LoopState:
    """The yield force dt [s] later, at the motion m, the mean of both gates between."""
    gate = float(p.damper.gate(m.x, m.v))
    duty = m.duty if 0.0 <= m.duty <= 1.0 else state.duty
    goal = p.damper.height(duty, left) * 0.5 * (state.gate + gate)
    force = respond(p.tau, state.force, goal, dt)
    if p.correction > 0.0 and math.isfinite(m.force):
        seen = m.force - p.damper.passive(m.x, m.v, left)
        force += p.correction * (seen - force)
    most = p.damper.height(1.0)
    return LoopState(min(max(force, -most), most), gate, state.duty)


def ahead(x: float, v: float, rate: float, time: float) -> tuple[float, float]:
    """Deflection [m] and velocity [m/s] a time [s] later; rate: of the velocity [m/s2], 0 where it is no number."""
    a = rate if math.isfinite(rate) else 0.0
    return x + time * (v + 0.5 * time * a), v + time * a


def duty_for(
    p: ForceLoop,
    state: LoopState,
    wanted: float,
    gate: float,
    dt: float,
    left: Factors,
    latency: float = 0.0,
) -> tuple[LoopState, float]:
    """Duty for a yield force [N] after `follow`, within all limits.

    gate: s of the motion while the duty will act. dt [s]: since the duty before. latency [s]: until it acts.
    """
    low, high = p.duties
    strength = p.damper.height(1.0, left)
    if gate == 0.0 or strength == 0.0:
        duty = low
    else:
        full = strength * math.copysign(max(abs(gate), p.least_gate), gate)
        goal = p.damper.height(state.duty, left) * gate
        kept = kept_after(p.tau, p.horizon)
        missing = wanted - kept * respond(p.tau, state.force, goal, latency)
        share = max(missing / (1.0 - kept) / full, 0.0)
        duty = min(max(min(share, 1.0) ** (1.0 / p.damper.beta), low), high)
    if left.electrical * duty**p.damper.beta < p.dead_zone**p.damper.beta:
        duty = low
    room = p.slew * dt
    duty = min(max(duty, state.duty - room), state.duty + room)
    return LoopState(state.force, state.gate, duty), duty
