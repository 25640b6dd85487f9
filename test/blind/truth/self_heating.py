"""Fluid warmed by what it dissipates: fluid film and housing as two heat capacities.

    C_f T_f' = P - g_f (T_f - T_w),   C_w T_w' = g_f (T_f - T_w) - g_a T_w,   P = h v >= 0
    viscosity  exp[B (1/T - 1/T_0)] with B = b_V T_0^2 (Arrhenius),  yield 1 / (1 + b_T T_f)

Temperatures are differences to the room T_0 = 293 K. The strength is b_V; b_T is a share of it. Yield forces of other
forms, which a drawn truth never has, are one family with it: (1 + p b_T T_f)^(-1/p), a hyperbola for p = 1, an
exponential for p = 0, a straight line that ends at zero for p = -1.
"""

from __future__ import annotations

import math

import numpy as np

from test.blind.effect import Effect, Scene, between
from test.blind.jit import inner
from test.blind.slots import HEATING

_ROOM = 293.0


@inner
def viscosity(film: float, strength: float) -> float:
    """Factor on the viscous force at film temperature [K above room]."""
    if strength == 0.0:
        return 1.0
    return math.exp(-strength * _ROOM * film / (_ROOM + film))


@inner
def yield_force(film: float, strength: float, share: float, bend: float) -> float:
    """Factor on the yield force at film temperature [K above room]; bend: p - 1, zero where drawn."""
    if strength == 0.0:
        return 1.0
    fall = share * strength * film
    if bend == 0.0:
        return 1.0 / (1.0 + fall)
    power = 1.0 + bend
    if power == 0.0:
        return math.exp(-fall)
    left = 1.0 + power * fall
    return float(left ** (-1.0 / power)) if left > 0.0 else 0.0


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Share b_T / b_V, capacities [J/K] and conductances [W/K] of film and housing."""
    del scene
    return (
        rng.uniform(0.3, 0.6),
        between(rng, 0.2, 0.5),
        rng.uniform(0.008, 0.02),
        between(rng, 10.0, 30.0),
        rng.uniform(0.05, 0.2),
    )


EFFECT = Effect(
    "self_heating",
    (
        ("b_V", "1/K"),
        ("b_T/b_V", "1"),
        ("C_f", "J/K"),
        ("g_f", "W/K"),
        ("C_w", "J/K"),
        ("g_a", "W/K"),
    ),
    0.03,
    5e-3,
    0.08,
    draw,
    slot=HEATING,
)
