r"""One sample of the fault-tolerant LPV controller: from deflection, its velocity and known faults to a duty.

.. math::  u_{er} = C(\rho) x_c, \quad x_c^+ = A(\rho) x_c + B(\rho) z_{def}, \quad \rho^+ = \rho(\varepsilon)

A, B, C are straight lines in rho between the exactly discretised vertices, which is what the certificate proves
for a rho that jumps at will. rho is that of the sample before: the force depends on it, and it on the force.

Source: thesis (6.14)-(6.17), (6.27); inverse damper model with the sign of the deflection velocity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from er_models.forms.loss import Factors
from er_models.model import Array
from er_models.static_damper import StaticDamper

from er_ftc_controller.gains import Loaded
from er_ftc_controller.schedule import Schedule, project, scheduling
from er_ftc_controller.synthesis.certificate import SAMPLE, sampled_controller


@dataclass(frozen=True, eq=False)
class Lpv:
    """Vertices at least and greatest rho: A (2, n, n), B (2, n) of 1 m, C (2, n) in N; damper, duties, schedule."""

    A: Array
    B: Array
    C: Array
    damper: StaticDamper
    duties: tuple[float, float]
    schedule: Schedule


class State(NamedTuple):
    """State of the controller (n,) and rho of the next sample."""

    x: Array
    rho: float


class Command(NamedTuple):
    """Duty [1]; force asked for and nearest that can be given [N]; rho; whether the sample was usable."""

    duty: float
    wanted: float
    given: float
    rho: float
    usable: bool


def controller(
    loaded: Loaded, damper: StaticDamper, duties: tuple[float, float], mu: float
) -> Lpv:
    """The controller of a proved gain file at 200 Hz; mu [N]: dead zone of rho."""
    plant, (low, high) = loaded.plant, loaded.plant.weights.rho
    sampled = [sampled_controller(k, SAMPLE * plant.rate) for k in loaded.solution.vertices]
    A, B, C = (np.array(parts) for parts in zip(*sampled, strict=True))
    road = plant.weights.road
    return Lpv(A, B[:, :, 0] / road, C[:, 0] * plant.unit, damper, duties, Schedule(low, high, mu))


def start(p: Lpv) -> State:
    """At rest, held back."""
    return State(np.zeros(p.A.shape[1]), p.schedule.high)


def step(p: Lpv, state: State, x: float, v: float, left: Factors) -> tuple[State, Command]:
    """Duty for a deflection [m], its velocity [m/s] and the faults; a sample that is no number gets the least duty."""
    if not (math.isfinite(x) and math.isfinite(v)):
        return start(p), Command(p.duties[0], 0.0, 0.0, p.schedule.high, usable=False)
    share = (state.rho - p.schedule.low) / (p.schedule.high - p.schedule.low)
    A, B, C = ((1.0 - share) * part[0] + share * part[1] for part in (p.A, p.B, p.C))
    at = np.array(x), np.array(v)
    wanted = float(p.damper.passive(*at, left)) + float(C @ state.x)
    given, distance = project(wanted, p.damper.domain(*at, p.duties, left))
    duty = p.damper.duty_for(np.array(given), *at, p.duties, left).duty
    command = Command(float(duty), wanted, given, state.rho, usable=True)
    return State(A @ state.x + B * x, scheduling(p.schedule, distance)), command
