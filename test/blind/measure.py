"""From the fine trajectory to what the instruments record at 200 Hz, without and with noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from test.blind.catalogue import INSIDE, OUTSIDE, VEHICLE
from test.blind.integrate import LEAD_SAMPLES, SAMPLE, STEP, SUBSTEPS
from test.blind.jit import Array
from test.blind.plant import Motion
from test.blind.slots import (
    FORCE_DELAY,
    OAS,
    OAU,
    OF,
    OUT_CROSSTALK,
    OUT_DRIFT,
    OUT_HUM,
    OV,
    OX,
)
from test.blind.truth import outside_signal

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
    """The fine trajectory as the instruments show it, frames before sensors; (m, outputs) both."""
    shown = fine.copy()
    for effect in (*OUTSIDE, *INSIDE, *VEHICLE):
        row = table[effect.slot]
        if "shown" in effect.acts and row[0] != 0.0:
            effect.acts["shown"](shown, STEP, *row[: len(effect.columns)])
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
