"""What the benchmarks compute: a damper along a motion, and the quarter car on a road."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array, Model
from er_models.prediction import Motion, motion
from er_models.scales import Scales

SCALES = Scales(force=20.0, deflection=0.010, velocity=0.15, duty=0.3)


@dataclass(frozen=True)
class Size:
    """How much is measured: length of a record [s], time for each figure [s]."""

    record: float = 60.0
    patience: float = 3.0


TINY = Size(record=2.0, patience=0.01)
"""For a look at whether the benchmarks still run."""


def damper(*names: str) -> Model:
    """A Guo damper with response time, and more effects, at their starts."""
    model = Model("bench", {}, SCALES)
    for name in ("passive", "guo_yield", "response", *names):
        model = model.with_effect(name)
    return model


def car() -> Model:
    """The quarter car of Table 2.1 with that damper."""
    values = {"m_s": 2.27, "m_us": 0.25, "k_s": 1396.0, "k_t": 12270.0}
    return damper().with_effect("quarter_car", values)


def drive(seconds: float) -> Motion:
    """Two sines within the envelope and a duty in steps of half a second, at 200 Hz."""
    t = np.arange(round(seconds / DT) + 1) * DT
    levels = SCALES.duty * np.random.default_rng(0).random(t.size // 100 + 1)
    parts = ((0.007, 2.0, 0.3), (0.001, 7.0, 0.0))

    def derivative(order: int) -> Array:
        total = np.zeros(t.size)
        for amplitude, f, phase in parts:
            omega = 2.0 * np.pi * f
            total += amplitude * omega**order * np.sin(omega * t + phase + 0.5 * np.pi * order)
        return total

    return motion(
        DT, derivative(0), derivative(1), np.repeat(levels, 100)[: t.size], derivative(2)
    )


def road(seconds: float) -> Array:
    """A chirp of 4 mm up to 10 Hz in the time (3.6.1), at 200 Hz."""
    t = np.arange(round(seconds / DT) + 1) * DT
    return np.asarray(0.004 * np.sin(np.pi * 10.0 / seconds * t**2))
