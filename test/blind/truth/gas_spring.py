"""Gas chamber behind a floating piston: polytropic law, or a bounded hyperbolic spring.

    polytropic   F = F_p [1 - (1 + x / L)^(-n) - n x / L]
    hyperbolic   F = F_p (x / L) [1 / (1 - (x / L)^2) - 1]

F_p is the gas force at rest, L the length of the gas column. The stiffness at rest is the base's
k0, so it is taken away here. Neither law is a polynomial.
"""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import inner
from test.blind.slots import GAS_SPRING


@inner
def force(x: float, strength: float, length: float, index: float, hyperbolic: float) -> float:
    """Force [N] at deflection x [m], less its value and slope at rest."""
    if strength == 0.0:
        return 0.0
    r = min(max(x / length, -0.9), 0.9)
    if hyperbolic > 0.5:
        return strength * r * (1.0 / (1.0 - r * r) - 1.0)
    return float(strength * (1.0 - (1.0 + r) ** (-index) - index * r))


def draw(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Column length from the stroke in use, polytropic index, and which of the two laws."""
    peak = float(np.max(np.abs(scene.deflection)))
    return peak * rng.uniform(1.8, 3.2), rng.uniform(1.05, 1.4), float(rng.random() < 0.4)


EFFECT = Effect(
    "gas_spring",
    (("F_p", "N"), ("L", "m"), ("n", "1"), ("hyperbolic", "1")),
    6.0,
    0.5,
    30.0,
    draw,
    acts={"elastic": force},
    slot=GAS_SPRING,
)
