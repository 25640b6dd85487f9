"""Forces that no catalogue is expected to hold; they act on the car.

position_periodic  A sin(2 pi x / p): a thread, a bent rod
x_v_coupling       c_xv x v: a one-sided taper
stroke_memory      A (L / 4 mm) v / sqrt(v^2 + v_e^2), L the length of the stroke before
stick_events       A b(t) v / sqrt(v^2 + v_e^2), b one in rare short bursts and zero else
"""

from __future__ import annotations

import math

import numpy as np

from test.blind.effect import Effect, Scene, nothing
from test.blind.jit import Array, inner
from test.blind.slots import OUT_COGGING, OUT_COUPLING, OUT_MEMORY, OUT_STICK, STROKE

_STROKE = 4e-3


@inner
def force(x: float, v: float, burst: float, memory: Array, rows: Array) -> float:
    """Sum of the four [N]; ``burst`` is b(t), ``memory`` the past strokes."""
    total = rows[OUT_COUPLING, 0] * x * v
    if rows[OUT_COGGING, 0] != 0.0:
        total += rows[OUT_COGGING, 0] * math.sin(2.0 * math.pi * x / rows[OUT_COGGING, 1])
    if rows[OUT_MEMORY, 0] != 0.0:
        width = rows[OUT_MEMORY, 1]
        gate = v / (v * v + width * width) ** 0.5
        total += rows[OUT_MEMORY, 0] * memory[STROKE] / _STROKE * gate
    if rows[OUT_STICK, 0] != 0.0:
        width = rows[OUT_STICK, 1]
        total += rows[OUT_STICK, 0] * burst * v / (v * v + width * width) ** 0.5
    return float(total)


def draw_pitch(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Pitch [m], at least one period in the stroke in use."""
    peak = float(np.quantile(np.abs(scene.deflection), 0.95))
    return (min(rng.uniform(1.5e-3, 4e-3), peak),)


def draw_width(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Width of the reversal [m/s]."""
    del scene
    return (rng.uniform(2.5e-3, 4e-3),)


def draw_bursts(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Width of the reversal [m/s] and events per second [1/s]."""
    return (*draw_width(rng, scene), rng.uniform(0.4, 1.2))


COGGING = Effect(
    "outside:position_periodic",
    (("A", "N"), ("p", "m")),
    0.6,
    0.05,
    6.0,
    draw_pitch,
    slot=OUT_COGGING,
)
COUPLING = Effect(
    "outside:x_v_coupling",
    (("c_xv", "N.s/m2"),),
    3000.0,
    300.0,
    6000.0,
    nothing,
    slot=OUT_COUPLING,
)
MEMORY = Effect(
    "outside:stroke_memory",
    (("A", "N"), ("v_e", "m/s")),
    0.5,
    0.05,
    1.5,
    draw_width,
    slot=OUT_MEMORY,
)
STICK = Effect(
    "outside:stick_events",
    (("A", "N"), ("v_e", "m/s"), ("rate", "1/s")),
    2.0,
    0.2,
    5.0,
    draw_bursts,
    slot=OUT_STICK,
)
