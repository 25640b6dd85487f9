r"""One sample of the fault-tolerant LPV controller: from deflection, its velocity and known faults to a force.

.. math::  u_{er} = C(\rho) x_c, \quad x_c^+ = A(\rho) x_c + B(\rho) z_{def} + E(\rho) (F_d^\perp - F_d), \quad
           \rho^+ = \rho(\varepsilon)

A, B, C are straight lines in rho between the exactly discretised vertices, which is what the certificate proves
for a rho that jumps at will. rho is that of the sample before: the force depends on it, and it on the force. E is
anti-windup: the controller is told the force that is given, as its observer of the car must be, for alone it need not
be stable; within the domain it changes nothing.

Source: thesis (6.14)-(6.17), (6.27). The duty for the force: `er_ftc_controller.force_loop`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from er_models.constants import SAMPLE_RATE
from er_models.errors import InputError
from er_models.forms.loss import Factors
from er_models.model import Array
from er_models.static_damper import Domain, StaticDamper

from er_ftc_controller.gains import Loaded
from er_ftc_controller.schedule import Schedule, project, scheduling
from er_ftc_controller.synthesis.certificate import bears, sampled_controller, sampled_force


@dataclass(frozen=True, eq=False)
class Lpv:
    """Vertices at least and greatest rho: A (2, n, n), B (2, n) of 1 m, C (2, n) in N; damper, duties, schedule.

    E (2, n) of 1 N: of a force beyond the one asked for.
    """

    A: Array
    B: Array
    E: Array
    C: Array
    damper: StaticDamper
    duties: tuple[float, float]
    schedule: Schedule

    @cached_property
    def vertices(self) -> Array:
        """All of both in one array (2, n + 3, n): A, B, C, E."""
        return np.stack(
            [np.vstack(each) for each in zip(self.A, self.B, self.C, self.E, strict=True)]
        )


class State(NamedTuple):
    """State of the controller (n,) and rho of the next sample."""

    x: Array
    rho: float


class Asked(NamedTuple):
    """Force asked for and nearest that can be given [N], passive force left in the damper [N], its gate, rho."""

    wanted: float
    given: float
    passive: float
    gate: float
    rho: float


def controller(
    loaded: Loaded,
    damper: StaticDamper,
    duties: tuple[float, float],
    mu: float,
    rate: float = SAMPLE_RATE,
) -> Lpv:
    """The controller of a proved gain file for so many samples per second; mu [N]: dead zone of rho.

    Raises `InputError` where no function is proved to bear jumps of rho between such samples.
    """
    plant, (low, high) = loaded.plant, loaded.plant.weights.rho
    if not bears(plant, loaded.solution, 1.0 / rate):
        expected = "samples per second with which the loop of the gains is proved"
        raise InputError("ftc_controller", "rate", expected, f"{rate:g}")
    step = 1.0 / rate * plant.rate
    sampled = [sampled_controller(k, step) for k in loaded.solution.vertices]
    E = np.array([sampled_force(plant, k, step)[:, 0] for k in loaded.solution.vertices])
    A, B, C = (np.array(parts) for parts in zip(*sampled, strict=True))
    road = plant.weights.road
    return Lpv(
        A,
        B[:, :, 0] / road,
        E / plant.unit,
        C[:, 0] * plant.unit,
        damper,
        duties,
        Schedule(low, high, mu),
    )


def start(p: Lpv) -> State:
    """At rest, held back."""
    return State(np.zeros(p.A.shape[1]), p.schedule.high)


@lru_cache(maxsize=4)
def _between(p: Lpv, rho: float) -> tuple[Array, Array, Array, Array]:
    """A (n, n), B, C, E (n,) at a rho: nearly always that of the sample before, since it rests at either end."""
    share = (rho - p.schedule.low) / (p.schedule.high - p.schedule.low)
    M = (1.0 - share) * p.vertices[0] + share * p.vertices[1]
    return M[:-3], M[-3], M[-2], M[-1]


def step(
    p: Lpv, state: State, x: float, then: tuple[float, float], left: Factors, restore: float = 0.0
) -> tuple[State, Asked]:
    """Force for a deflection [m] and the faults, all finite.

    then: deflection and velocity [m, m/s] at which the force will be made.
    restore: share of the passive force lost to the faults that the field is to give back.
    """
    A, B, C, E = _between(p, state.rho)
    passive, gate = float(p.damper.passive(*then, left)), float(p.damper.gate(*then))
    lost = float(p.damper.passive(*then)) - passive if restore else 0.0
    wanted = passive + float(C @ state.x) + restore * lost
    ends = p.damper.ends(passive, gate, p.duties, left)
    given, distance = project(wanted, Domain(*sorted(ends)))  # type: ignore[arg-type]
    asked = Asked(wanted, given, passive, gate, state.rho)
    x_c = A @ state.x + B * x + E * (given - wanted)
    return State(x_c, scheduling(p.schedule, distance)), asked
