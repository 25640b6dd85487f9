r"""The static damper law, its inverse, and the forces it can give, healthy or faulty.

.. math::  F_d = f_2 \big(k_0 x + f_3 (c_0 v + f_1 \sigma u^\beta s)\big), \quad s = \tanh(k_1 x + c_1 v)

Bingham (1.23) has k_1 = 0 and a steep c_1, so that s is the sign of the velocity; Guo (1.10) has beta = 1.

Source: thesis (6.1)-(6.11), (6.14). Its (6.6) multiplies by sign(v) where this divides by s: the same for a sign.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from er_models.errors import InputError
from er_models.forms.loss import Factors
from er_models.model import Array, Model

HEALTHY = Factors()
N = TypeVar("N", float, Array)
"""Numbers, or arrays (n,) of them."""
CORE = ("passive", "guo_yield", "bingham_yield", "response", "quarter_car")
"""Terms of the static law, with its response time, and the car around it."""


class Mimic(NamedTuple):
    """Duties (n,) [1], held within their limits, and whether each is the one that was looked for (n,)."""

    duty: Array
    exists: NDArray[np.bool_]


class Domain(NamedTuple):
    """Smallest and largest force [N] at each instant (n,), or numbers."""

    low: Array
    high: Array


@dataclass(frozen=True)
class StaticDamper:
    """k0 [N/m], c0 [N s/m], yield force sigma u**beta [N], slopes of the gate k1 [1/m] and c1 [s/m]."""

    k0: float
    c0: float
    sigma: float
    beta: float
    k1: float
    c1: float

    def gate(self, x: N, v: N) -> N:
        """Smooth sign s of the motion, (n,)."""
        sign: N = np.tanh(self.k1 * x + self.c1 * v)
        return sign

    def passive(self, x: N, v: N, left: Factors = HEALTHY) -> N:
        """Force without field [N], (n,): f_2 (k0 x + f_3 c0 v)."""
        viscous = left.deformation * self.c0
        return left.leakage * (self.k0 * x + viscous * v)

    def height(self, duty: N, left: Factors = HEALTHY) -> N:
        """Size of the yield force [N], (n,): f_1 f_2 f_3 sigma u**beta."""
        kept = left.electrical * left.leakage * left.deformation
        size: N = kept * self.sigma * duty**self.beta
        return size

    def force(self, x: Array, v: Array, duty: Array | float, left: Factors = HEALTHY) -> Array:
        """Damper force (6.8) [N], (n,)."""
        size = self.height(np.asarray(duty, float), left)
        return self.passive(x, v, left) + size * self.gate(x, v)

    def ends(
        self, passive: N, gate: N, duties: tuple[float, float], left: Factors = HEALTHY
    ) -> tuple[N, N]:
        """Forces [N] at two duties, in their order, (n,) each, for the motion's `passive` and `gate`."""
        first, second = (passive + self.height(duty, left) * gate for duty in duties)
        return first, second

    def domain(
        self, x: Array, v: Array, duties: tuple[float, float], left: Factors = HEALTHY
    ) -> Domain:
        """Forces between the least and the greatest duty (6.14), low before high whatever the motion."""
        ends = self.ends(self.passive(x, v, left), self.gate(x, v), duties, left)
        return Domain(np.minimum(*ends), np.maximum(*ends))

    def duty_for(
        self,
        force: Array,
        x: Array,
        v: Array,
        duties: tuple[float, float],
        left: Factors = HEALTHY,
    ) -> Mimic:
        """Duty that makes a damper of these faults give a force (n,) [N], the inverse of (6.8).

        Where none between the limits does, the nearest limit; without any gate or field left, the least duty.
        """
        lever = self.gate(x, v) * self.height(1.0, left)
        missing = np.asarray(force - self.passive(x, v, left))
        some = np.abs(lever) > np.finfo(float).tiny
        ratio = np.divide(missing, lever, out=np.zeros_like(lever), where=some)
        duty = np.clip(ratio, 0.0, None) ** (1.0 / self.beta)
        low, high = duties
        inside = some & (ratio >= 0.0) & (duty >= low) & (duty <= high)
        exists = np.where(some, inside, missing == 0.0)
        return Mimic(np.clip(duty, low, high), np.asarray(exists))

    def mimic(
        self,
        x: Array,
        v: Array,
        duty: Array,
        left: Factors,
        duties: tuple[float, float] = (0.0, 1.0),
    ) -> Mimic:
        """Duty at which the healthy damper gives the force of the faulty one: (6.3), (6.7), (6.11), all at once.

        x, v (n,): motion; duty (n,): of the faulty damper. A healthy damper cannot give less than its own passive
        force, so none exists where the loss of the passive force exceeds what is left of the yield force.
        """
        return self.duty_for(self.force(x, v, duty, left), x, v, duties)


def static_damper(model: Model) -> StaticDamper:
    """The static law in a model; a response time is left out.

    Raises `InputError` where the damper has other terms, which no such law holds.
    """
    extra = [n for n in model.effects if n not in CORE and model.catalogue[n].stage != "vehicle"]
    terms = [term.name for term in model.terms]
    laws = [n for n in ("guo_yield", "bingham_yield") if n in model.effects]
    if extra or terms or len(laws) != 1 or "passive" not in model.effects:
        expected = "passive and one of guo_yield and bingham_yield, perhaps response"
        raise InputError(model.name, "effects", expected, ", ".join([*model.effects, *terms]))
    k0, c0 = (model.value("passive", name) for name in ("k0", "c0"))
    if laws == ["guo_yield"]:
        f_c, k1, c1 = (model.value("guo_yield", name) for name in ("f_c", "k1", "c1"))
        return StaticDamper(k0, c0, f_c, 1.0, k1, c1)
    sigma, beta, v_0 = (model.value("bingham_yield", name) for name in ("sigma", "beta", "v_0"))
    return StaticDamper(k0, c0, sigma, beta, 0.0, 1.0 / v_0)
