"""Top joint in series with the damper: a rubber bush, a gap, or both.

    bush   F = (d / S) [1 + (d / d_h)^2] + e d' / S,   d = x - x_d
    gap    F = 0 for |d| < g; beyond it a contact k_c (d + e d'), never pulling

x_d is the travel the damper itself sees; it moves so that damper and joint carry one force.
e = 0.3 ms is the loss of rubber and of contact. With the field on and below yield the damper is
so stiff that a bush of 100 kN/m already shows, which is why S starts so low.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import Array, inner
from test.blind.slots import FREEPLAY, MOUNT

_LOSS = 3e-4


@inner
def present(rows: Array) -> bool:
    """Whether anything gives between car and damper."""
    return bool(rows[MOUNT, 0] != 0.0 or rows[FREEPLAY, 0] != 0.0)


@inner
def force(d: float, rate: float, rows: Array) -> float:
    """Force [N] of the joint stretched by d [m] at d' [m/s]."""
    compliance, knee, gap = rows[MOUNT, 0], rows[MOUNT, 1], rows[FREEPLAY, 0]
    if gap > 0.0:
        compliance += 1.0 / rows[FREEPLAY, 1]
        d = max(d - gap, 0.0) + min(d + gap, 0.0)
        if d == 0.0:
            return 0.0
    hardening = 1.0 + (d / knee) ** 2 if knee > 0.0 else 1.0
    pull = d / compliance * hardening + _LOSS * rate / compliance
    if gap > 0.0 and pull * d < 0.0:
        return 0.0
    return float(pull)


def draw_mount(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Stretch at which the bush is twice as stiff [m]."""
    del scene
    return (rng.uniform(2e-3, 4e-3),)


def draw_gap(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Contact stiffness [N/m]."""
    del scene
    return (rng.uniform(1.5e6, 3e6),)


BUSH = Effect(
    "mount_compliance", (("S", "m/N"), ("d_h", "m")), 1e-5, 2e-6, 2e-4, draw_mount, slot=MOUNT
)
GAP = Effect("freeplay", (("g", "m"), ("k_c", "N/m")), 4e-5, 4e-6, 5e-4, draw_gap, slot=FREEPLAY)
