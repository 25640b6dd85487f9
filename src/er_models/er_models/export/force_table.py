"""Force over velocity and duty, as a damper dynamometer finds it: the peak velocity pick-off.

The damper runs a sine of its usual stroke at constant duty. The force is read in the middle of the stroke, where the
velocity is the peak and acceleration and deflection are zero, after two whole cycles: springs and inertia give nothing
there, and what lags or slips is in its cycle. Each velocity is a sine of its own frequency; at zero the damper rests.

Source: peak velocity pick-off (PVP), the usual test of damper makers; Dixon, The Shock Absorber Handbook.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from er_models.kernel.order import reads
from er_models.model import Array, Model
from er_models.prediction import join, motion, predict

LEVELS, DUTIES = 10, 7
"""Velocities on either side of zero, closer to each other near it; duties from 0 to the largest."""
SAMPLES, CYCLES = 400, 2
"""Samples of a cycle, and cycles before the force is read."""


@dataclass(frozen=True)
class ForceTable:
    """velocity (n,) [m/s], duty (m,) [1], force (n, m) [N] without the sensors; amplitude: of the sines [m]."""

    velocity: Array
    duty: Array
    force: Array
    amplitude: float


def without_sensors(model: Model) -> Model:
    """The damper itself: the model without what its sensors do to motion and force."""
    for name in [n for n in model.effects if model.catalogue[n].stage == "sensing"]:
        model = model.without_effect(name)
    return model


def force_table(model: Model) -> ForceTable:
    """Force of a model's damper up to the largest velocity and duty of its rig, else of its envelope."""
    model, rig, s = without_sensors(model), model.rig, model.scales
    amplitude = min(s.deflection, rig.get("stroke", s.deflection))
    fastest = rig.get("velocity_max", s.velocity)
    driven = reads((model.catalogue[name] for name in model.effects), "u")
    duty = np.linspace(0.0, rig.get("duty_max", s.duty), DUTIES) if driven else np.zeros(1)
    speed = fastest * (np.arange(1, LEVELS + 1) / LEVELS) ** 2
    rows = [_at_rest(model, duty), *(_both_ways(model, duty, amplitude, v) for v in speed)]
    pulled, pushed = [rows[0][0], *(r[0] for r in rows[1:])], [r[1] for r in rows[1:]]
    return ForceTable(
        np.concatenate([-speed[::-1], [0.0], speed]), duty, np.array([*pushed[::-1], *pulled]), amplitude
    )  # fmt: skip


def _at_rest(model: Model, duty: Array) -> Array:
    """Force (1, m) in the middle of the stroke at rest."""
    nothing = np.zeros(duty.size)
    each = replace(motion(1.0, nothing, nothing, duty, nothing), starts=np.arange(duty.size + 1))
    return predict(model, each)[None]


def _both_ways(model: Model, duty: Array, amplitude: float, v: float) -> Array:
    """Force (2, m) in the middle of the stroke at +v and -v."""
    phase = 2.0 * np.pi * np.arange(CYCLES * SAMPLES + SAMPLES // 2 + 1) / SAMPLES
    pace = v / amplitude
    sine = np.stack([amplitude * np.sin(phase), v * np.cos(phase), -v * pace * np.sin(phase)])
    dt = 2.0 * np.pi / (pace * SAMPLES)
    runs = join([motion(dt, sine[0], sine[1], np.full(phase.size, u), sine[2]) for u in duty])
    force = predict(model, runs)
    ends = [j for _, j in pairwise(runs.starts.tolist())]
    return np.array([[force[j - 1 - SAMPLES // 2] for j in ends], [force[j - 1] for j in ends]])
