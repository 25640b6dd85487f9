"""Gap at the piston ring beside the fluid's own way: laminar and turbulent, v = v_m + a F + b sqrt(F).

The fluid's own way gives f_h at the whole velocity and is straight from there to nothing; the share that is left to it
is found by halving.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner

HALVINGS = 50


@inner
def force(f: float, v: float, strength: float, laminar: float, size: float) -> float:
    """Force [N] where f would be without the gap; strength [m/s] passes at `size` [N], so much of it laminar."""
    if strength == 0.0:
        return f
    full, speed = abs(f), abs(v)
    low, high = 0.0, full
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        r = middle / size
        flow = speed * middle / max(full, 1e-300) + strength * (
            laminar * r + (1.0 - laminar) * r**0.5
        )
        if flow > speed:
            high = middle
        else:
            low = middle
    return float(0.5 * (low + high) * (1.0 if f > 0.0 else -1.0))


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Laminar share of the flow, and the force that it is told at [N]."""
    return rng.uniform(0.0, 0.25), float(np.max(np.abs(scene.hydraulic)))


EFFECT = Effect(
    "piston_leakage",
    (("v_l", "m/s"), ("q", "1"), ("F", "N")),
    0.02,
    0.002,
    0.08,
    draw,
    acts={"bypass": force},
)
