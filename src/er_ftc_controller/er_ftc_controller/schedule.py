r"""The semi-active domain of a damper, the projection on it, and the scheduling parameter of the LPV controller.

.. math::  \varepsilon = |F_d - F_d^\perp|, \quad
           \rho = \underline\rho + (\bar\rho - \underline\rho)\, \mathrm{sat}_0^1 (\varepsilon / \mu - 1)

The force asked for lies within the domain: epsilon is 0 and the controller is free (least rho). It is farther
outside than 2 mu: the controller is held back to the passive force (greatest rho).

Source: thesis (6.14), (6.16), (6.17), with the bars and the absolute value that its print has lost.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from er_models.errors import InputError
from er_models.forms.loss import Factors
from er_models.static_damper import HEALTHY, Domain, StaticDamper


@dataclass(frozen=True)
class Schedule:
    """Range of rho [1] and the dead zone mu [N]; raises `InputError` where they are none."""

    low: float
    high: float
    mu: float

    def __post_init__(self) -> None:
        if not 0.0 < self.low < self.high:
            raise InputError("schedule", "low, high", "0 < low < high", f"{self.low}, {self.high}")
        if not self.mu > 0.0:
            raise InputError("schedule", "mu", "a force above 0 N", self.mu)


class Projected(NamedTuple):
    """Nearest force that can be given [N], and how far away the one asked for is [N], not negative."""

    force: float
    distance: float


def project(force: float, domain: Domain) -> Projected:
    """Nearest point of the domain to a force [N]."""
    nearest = min(max(force, float(domain.low)), float(domain.high))
    return Projected(nearest, abs(force - nearest))


def scheduling(p: Schedule, distance: float) -> float:
    """Rho (6.16) for the distance to the domain [N]; the greatest, the passive one, where it is no number."""
    if not math.isfinite(distance):
        return p.high
    return p.low + (p.high - p.low) * min(max(distance / p.mu - 1.0, 0.0), 1.0)


def kept_after(tau: float, time: float) -> float:
    """Share of a yield force that is left after a time [s] without field."""
    return math.exp(-time / tau) if tau > 0.0 else 0.0


def respond(tau: float, force: float, goal: float, time: float) -> float:
    """Yield force [N] after a time [s] on its way to a goal held: tau F' + F = goal (2.10), solved."""
    kept = kept_after(tau, time)
    return kept * force + (1.0 - kept) * goal


def reachable(
    damper: StaticDamper,
    tau: float,
    yield_force: float,
    motion: tuple[float, float],
    duties: tuple[float, float],
    horizon: float,
    left: Factors = HEALTHY,
) -> Domain:
    """Forces [N] that the dynamic damper can give after `horizon` [s], its motion (x, v) held.

    The yield force moves on the exact solution of tau F' + F = height(u) gate from where it is [N]; with time it
    fills the static domain (6.14). yield_force: as (6.8) counts it, with its faults. At rest of the response,
    tau = 0, it is the static domain at once.
    """
    x, v = motion
    gate, passive = float(damper.gate(x, v)), float(damper.passive(x, v, left))  # type: ignore[arg-type]
    ends = [
        passive + respond(tau, yield_force, float(damper.height(u, left)) * gate, horizon)
        for u in duties
    ]
    return Domain(np.asarray(min(ends)), np.asarray(max(ends)))
