"""Models, motions and references that several tests of the model library share."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
from er_models.catalogue import CATALOGUE, Catalogue
from er_models.effect import Effect
from er_models.files import load_model
from er_models.model import Array, Model
from er_models.prediction import Motion, motion
from er_models.scales import Scales
from reference import vehicle_rate

CONFIG = Path(__file__).resolve().parents[3] / "config"
SMALL = Scales(force=20.0, deflection=0.010, velocity=0.15, duty=0.3)
LARGE = Scales(force=2000.0, deflection=0.050, velocity=0.6, duty=1.0)
DT = 0.005


def guo() -> Model:
    """The dynamic Guo damper of Table 1.6."""
    return load_model(CONFIG / "dampers" / "inove_guo.yaml")


def bingham() -> Model:
    """The static Bingham damper of Table 1.6."""
    return load_model(CONFIG / "dampers" / "inove_bingham.yaml")


def car() -> Model:
    """The quarter car of Table 2.1 with the Guo damper."""
    return load_model(CONFIG / "vehicles" / "inove_quarter_car.yaml")


def started(scales: Scales, *names: str, catalogue: Catalogue = CATALOGUE) -> Model:
    """A model of these effects at their first starts, for a damper of these scales."""
    model = Model("started", {}, scales, catalogue=catalogue)
    for name in names:
        model = model.with_effect(name)
    return model


def typical(model: Model, effect: Effect) -> Model:
    """The model with an effect at its first starts."""
    return model.with_effect(effect.name)


def neutral(model: Model, effect: Effect) -> Model:
    """The model with an effect that does nothing: neutral where that is a value, else at the start."""
    values = {
        q.name: model.start(effect.name, q.name)
        if q.neutral is None
        else q.neutral * model.scales.of(q.unit)
        for q in effect.parameters
    }
    return model.with_effect(effect.name, values)


def box(effect: Effect, scales: Scales) -> list[dict[str, float]]:
    """Corners and random points of an effect's parameter box [SI]."""
    sides = []
    for q in effect.parameters:
        high = min(q.high, 1e6)
        sides.append((q.low * scales.of(q.unit), high * scales.of(q.unit)))
    inside = np.random.default_rng(3).random((8, len(sides)))
    points = [*itertools.product(*sides)]
    points += [tuple(a + r * (b - a) for (a, b), r in zip(sides, row)) for row in inside]
    return [dict(zip(effect.names, point)) for point in points]


class Sine:
    """A smooth imposed motion: two sines that fill the envelope of a damper, with exact derivatives."""

    def __init__(self, scales: Scales, share: float = 0.9) -> None:
        slow = share * scales.velocity / (2.0 * scales.deflection)
        self.parts = (
            (share * 0.8 * scales.deflection, slow, 0.3),
            (share * 0.2 * scales.deflection, 3.7 * slow, 1.1),
        )

    def derivative(self, t: Array | float, order: int) -> Array:
        """The motion (order 0) or its derivative at times t."""
        total = np.zeros(np.shape(t))
        for amplitude, omega, phase in self.parts:
            total = total + amplitude * omega**order * np.sin(
                omega * np.asarray(t) + phase + 0.5 * np.pi * order
            )
        return total


def imposed(scales: Scales, seconds: float, dt: float = DT, seed: int = 0) -> Motion:
    """The two sines with a duty that steps within the envelope, zero now and then, while it warms by 4 K a second."""
    n = round(seconds / dt) + 1
    t = np.arange(n) * dt
    sine = Sine(scales)
    levels = scales.duty * np.random.default_rng(seed).choice([0.0, 0.2, 0.5, 0.8, 1.0], n)
    duty = np.repeat(levels, 41)[:n]
    x, v, a = (sine.derivative(t, order) for order in range(3))
    return motion(dt, x, v, duty, a, 4.0 * t)


def one_sample(x: float, v: float, u: float, a: float = 0.0, theta: float = 0.0) -> Motion:
    """A record of a single sample, in which every state is in equilibrium."""
    return motion(DT, *(np.array([value]) for value in (x, v, u, a, theta)))


def span(y: Array) -> float:
    """Range of a signal: what errors are measured against, as in (3.79)."""
    return float(np.ptp(y))


def exact_rates(
    model: Model, x: Array, u: float, road_rate: float, t: float = 0.0
) -> tuple[Array, Array]:
    """Rate of the thesis's state (5,) and outputs (3,) from the right-hand side."""
    slot = model.catalogue.slots["response"]
    w = np.zeros(model.catalogue.n_states)
    w[slot] = x[4]
    dq, dw, outputs = vehicle_rate(model, x[:4].copy(), w, u, road_rate, t)
    return np.append(dq, dw[slot]), outputs


def random_points(model: Model, n: int, seed: int) -> list[tuple[Array, float, float]]:
    """States, duties and road rates all over the envelope."""
    r, s = np.random.default_rng(seed), model.scales
    size = np.array([s.deflection, s.velocity, s.deflection, s.velocity, s.force])
    return [(size * r.uniform(-2, 2, 5), r.uniform(0, 1), r.uniform(-1, 1)) for _ in range(n)]
