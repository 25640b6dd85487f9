"""accelerometer_bias: both accelerometers show a little when nothing moves."""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import Array
from test.blind.slots import BIAS, OAS, OAU


def draw_other(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Bias of the wheel's accelerometer over that of the body's."""
    del scene
    return (rng.uniform(-1.0, 1.0),)


def biased(shown: Array, step: float, bias: float, ratio: float) -> None:
    """Both accelerations [m/s2]."""
    del step
    shown[:, OAS] += bias
    shown[:, OAU] += bias * ratio


EFFECT = Effect(
    "accelerometer_bias", (("b_s", "m/s2"), ("ratio", "1")), 0.1, 0.04, 0.3, draw_other,
    most_negative=0.3, shown_by_force=False, acts={"shown": biased}, slot=BIAS,
)  # fmt: skip
