"""Measurements of a damper with Coulomb friction, as long as wanted."""

from __future__ import annotations

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array, Model
from er_models.prediction import motion, predict
from er_records.record import Record

FREQUENCIES = (0.7, 1.3, 2.1, 3.4, 5.2, 7.3)
DUTIES, HOLD = (0.0, 0.1, 0.2, 0.3), 150
"""Levels of the duty, and samples that each is held."""
NOISE = {
    "deflection": 2e-5, "deflection_velocity": 1e-3, "damper_force": 0.15, "sprung_acceleration": 0.025,
    "unsprung_acceleration": 0.025, "duty": 0.0,
}  # fmt: skip


def truth(model: Model) -> Model:
    """The model with friction of a twentieth of its envelope, which the lab has to find."""
    force, velocity = model.scales.force, model.scales.velocity
    return model.with_effect("coulomb_friction", {"F_c": 0.05 * force, "v_0": 0.02 * velocity})


def record(model: Model, seconds: float, seed: int = 0, damper: Model | None = None) -> Record:
    """Six sines within the velocity of the model, steps of the duty, noise of every sensor.

    damper: what makes the force; else the `truth` of the model.
    """
    rng, n = np.random.default_rng(seed), round(seconds / DT)
    t: Array = np.asarray(np.arange(n) * DT, np.float64)
    w: Array = np.asarray(2.0 * np.pi * np.array(FREQUENCIES), np.float64)
    phase = rng.uniform(0.0, 2.0 * np.pi, w.size)
    size = 0.45 * model.scales.velocity / w / np.sqrt(w.size)
    x, v, a = (_derivative(t, w, phase, size, order) for order in range(3))
    u = np.repeat(rng.choice(DUTIES, n // HOLD + 1), HOLD)[:n]
    force = predict(damper or truth(model), motion(DT, x, v, u, a))
    channels = {
        "deflection": x, "deflection_velocity": v, "duty": u, "damper_force": force, "sprung_acceleration": a,
        "unsprung_acceleration": np.zeros(n),
    }  # fmt: skip
    noisy = {
        k: np.asarray(y + NOISE[k] * rng.standard_normal(n), np.float64)
        for k, y in channels.items()
    }
    return Record("bench", t, noisy)


def _derivative(t: Array, w: Array, phase: Array, size: Array, order: int) -> Array:
    """A derivative of the sum of sines (n,), sine by sine: hours of them must fit the memory."""
    total = np.zeros(t.size)
    for omega, p, s in zip(w, phase, size, strict=True):
        total += s * omega**order * np.sin(omega * t + p + 0.5 * np.pi * order)
    return total
