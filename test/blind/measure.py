"""From the fine trajectory to what the instruments record at 200 Hz, without and with noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from test.blind.integrate import LEAD_SAMPLES, SAMPLE, STEP, SUBSTEPS
from test.blind.jit import Array
from test.blind.plant import Motion
from test.blind.slots import (
    BIAS,
    DEFLECTION_ZERO,
    FORCE_DELAY,
    FORCE_LAG,
    OAS,
    OAU,
    OF,
    OUT_CROSSTALK,
    OUT_DRIFT,
    OUT_HUM,
    OUT_RESONANCE,
    OV,
    OX,
    VELOCITY_LAG,
)
from test.blind.truth import outside_signal, sensing

COLUMNS = (
    "t",
    "road",
    "deflection",
    "deflection_velocity",
    "duty",
    "damper_force",
    "sprung_acceleration",
    "unsprung_acceleration",
)
NoiseKind = Literal["white", "ar1"]


@dataclass(frozen=True)
class Noise:
    """Standard deviations of the instruments' noise [SI]; the force may be coloured.

    Attributes:
        force, velocity, deflection, acceleration: [N], [m/s], [m], [m/s2].
        kind: white, or first-order autoregressive force noise of the same variance.
        memory: correlation of the coloured noise from one sample to the next.
    """

    force: float = 0.15
    velocity: float = 1e-3
    deflection: float = 20e-6
    acceleration: float = 0.025
    kind: NoiseKind = "white"
    memory: float = 0.5


def instruments(fine: Array, table: Array) -> Array:
    """The fine trajectory as the instruments show it: resonance, lags, zero and bias; (m, outputs) both."""
    shown = fine.copy()
    if table[OUT_RESONANCE, 0] != 0.0:
        row = table[OUT_RESONANCE]
        shown[:, OF] += row[0] * (
            outside_signal.frame(fine[:, OF], STEP, row[1], row[2]) - fine[:, OF]
        )
    if table[FORCE_LAG, 0] != 0.0:
        shown[:, OF] = sensing.lagged(shown[:, OF], STEP, table[FORCE_LAG, 0])
    if (lag := table[VELOCITY_LAG, 0]) != 0.0:
        shown[:, OV] = sensing.lagged(sensing.lagged(fine[:, OV], STEP, lag), STEP, 0.2 * lag)
    shown[:, OX] += table[DEFLECTION_ZERO, 0]
    shown[:, OAS] += table[BIAS, 0]
    shown[:, OAU] += table[BIAS, 0] * table[BIAS, 1]
    return shown


def _sampled_force(shown: Array, motion: Motion, table: Array) -> Array:
    """Force [N] at 200 Hz: late by its delay, with what is made of samples."""
    fine_t = np.arange(shown.shape[0]) * STEP
    at = np.asarray(np.arange(motion.duty.size) * SAMPLE, dtype=np.float64)
    sampled = np.interp(at - table[FORCE_DELAY, 0], fine_t, shown[:, OF])
    if table[OUT_HUM, 0] != 0.0:
        sampled = sampled + outside_signal.hum(at, table[OUT_HUM])
    if table[OUT_CROSSTALK, 0] != 0.0:
        sampled = sampled + outside_signal.crosstalk(motion.duty, SAMPLE, table[OUT_CROSSTALK])
    if table[OUT_DRIFT, 0] != 0.0:
        walk = np.random.default_rng([int(table[OUT_DRIFT, 1]), motion.burst_seed])
        sampled = sampled + outside_signal.drift(at.size, table[OUT_DRIFT, 0], walk)
    return np.asarray(sampled)


def noiseless(fine: Array, motion: Motion, table: Array, seconds: float) -> dict[str, Array]:
    """Contract columns without noise, each (round(seconds / SAMPLE),)."""
    n = round(seconds / SAMPLE)
    keep = slice(LEAD_SAMPLES, LEAD_SAMPLES + n)
    half = motion.drive[: -1 : 2 * SUBSTEPS, 0]
    road = half if motion.rig == "car" else np.zeros(half.size)
    shown = instruments(fine, table)
    every = shown[:-1:SUBSTEPS]
    return {
        "t": np.arange(n) * SAMPLE,
        "road": road[keep],
        "deflection": every[keep, OX],
        "deflection_velocity": every[keep, OV],
        "duty": motion.duty[keep],
        "damper_force": _sampled_force(shown, motion, table)[keep],
        "sprung_acceleration": every[keep, OAS],
        "unsprung_acceleration": every[keep, OAU],
    }


def with_noise(
    clean: dict[str, Array], noise: Noise, rng: np.random.Generator
) -> dict[str, Array]:
    """The same columns with the instruments' noise; time, road and duty are known exactly."""
    n = clean["t"].size
    draws = rng.standard_normal((5, n))
    force = draws[0].copy()
    if noise.kind == "ar1":
        fresh = np.sqrt(1.0 - noise.memory**2)
        for k in range(1, n):
            force[k] = noise.memory * force[k - 1] + fresh * draws[0, k]
    added = {
        "damper_force": noise.force * force,
        "deflection_velocity": noise.velocity * draws[1],
        "deflection": noise.deflection * draws[2],
        "sprung_acceleration": noise.acceleration * draws[3],
        "unsprung_acceleration": noise.acceleration * draws[4],
    }
    return {name: value + added.get(name, 0.0) for name, value in clean.items()}
