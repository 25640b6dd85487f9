"""The undisturbed damper and car, and the program of motions and duties of a case.

Values from the thesis: Table 1.6 (damper) and Table 2.1 (quarter car).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from test.blind import roads
from test.blind.catalogue import N_EFFECTS
from test.blind.integrate import LEAD_SAMPLES, SUBSTEPS, run
from test.blind.jit import Array
from test.blind.slots import N_COLUMNS, OUT_STICK, OV, OX

Rig = Literal["car", "damper"]
Program = Literal["rich", "constant_duty", "one_sine"]

NOMINAL = np.array([263.1168, 64.6433, 29.2780, 204.0283, 492.6448, 0.0365])
CAR = np.array([2.27, 0.25, 1396.0, 12270.0])
SPREAD = 0.12
STROKE_LIMIT = 0.0105
_MOST_VELOCITY, _MOST_STROKE = 0.16, 0.012
NO_EFFECT: Array = np.zeros((N_EFFECTS, N_COLUMNS))


@dataclass(frozen=True)
class Motion:
    """One record's inputs.

    Attributes:
        rig: quarter car on a road, or imposed stroke.
        drive: road [m] in column 0, or stroke, velocity, acceleration, (2 n SUBSTEPS + 1, 3).
        duty: (n,), held from each sample to the next.
        burst_seed: seed of the rare events, used only by the effect that has them.
    """

    rig: Rig
    drive: Array
    duty: Array
    burst_seed: int


def draw_base(rng: np.random.Generator) -> Array:
    """k0, c0, fc, k1, c1, tau, each up to 12 % off its nominal value, (6,)."""
    return np.asarray(NOMINAL * (1.0 + rng.uniform(-SPREAD, SPREAD, NOMINAL.size)))


def trajectory(motion: Motion, table: Array, base: Array) -> Array:
    """Fine trajectory of one record, (n SUBSTEPS + 1, N_OUT)."""
    n = motion.duty.size
    burst = np.zeros(n)
    if table[OUT_STICK, 0] != 0.0:
        burst = roads.bursts(
            n, float(table[OUT_STICK, 2]), np.random.default_rng(motion.burst_seed)
        )
    rig = int(motion.rig == "damper")
    return run(rig, motion.drive, motion.duty, burst, table, base, CAR)


def _scaled(motion: Motion, base: Array, rng: np.random.Generator) -> Motion:
    """The motion with its size set: peak velocity 0.10 to 0.15 m/s, stroke within its limit."""
    peak_velocity, peak_stroke = rng.uniform(0.10, 0.15), rng.uniform(0.007, STROKE_LIMIT)
    for _ in range(1 if motion.rig == "damper" else 3):
        fine = trajectory(motion, NO_EFFECT, base)[LEAD_SAMPLES * SUBSTEPS :]
        size = min(
            peak_velocity / float(np.max(np.abs(fine[:, OV]))),
            peak_stroke / float(np.max(np.abs(fine[:, OX]))),
        )
        motion = replace(motion, drive=motion.drive * size)
        if abs(size - 1.0) < 0.05:
            break
    return motion


def within_limits(motions: tuple[Motion, ...], table: Array, base: Array) -> tuple[Motion, ...]:
    """The same tuple where the disturbed car stays within the rig's limits, else smaller roads."""
    kept = []
    for motion in motions:
        fine = trajectory(motion, table, base)[LEAD_SAMPLES * SUBSTEPS :]
        size = min(
            _MOST_VELOCITY / float(np.max(np.abs(fine[:, OV]))),
            _MOST_STROKE / float(np.max(np.abs(fine[:, OX]))),
        )
        small = size < 1.0 and motion.rig == "car"
        kept.append(replace(motion, drive=motion.drive * (0.95 * size)) if small else motion)
    same = all(new is old for new, old in zip(kept, motions, strict=True))
    return motions if same else tuple(kept)


def _drive(rig: Rig, program: Program, n: int, kind: int, rng: np.random.Generator) -> Array:
    """Unscaled road or imposed stroke at the half steps, (2 n SUBSTEPS + 1, 3)."""
    if rig == "damper":
        return roads.one_sine(n, rng) if program == "one_sine" else roads.imposed(n, kind, rng)
    drive = np.zeros((2 * n * SUBSTEPS + 1, 3))
    if program == "one_sine":
        drive[:, 0] = roads.one_sine(n, rng)[:, 0]
    else:
        drive[:, 0] = roads.road(n, kind, rng)
    return drive


def draw_motions(
    rig: Rig,
    program: Program,
    n_records: int,
    seconds: float,
    base: Array,
    seed: np.random.SeedSequence,
) -> list[Motion]:
    """Inputs of all records, each with another road and duty.

    The two poor programs hold one duty in all records; ``one_sine`` also repeats one sine.
    """
    n = roads.n_samples(seconds)
    common = np.random.default_rng(seed)
    first, held = int(common.integers(len(roads.KINDS))), round(common.uniform(0.05, 0.25), 3)
    motions = []
    for index, child in enumerate(seed.spawn(n_records)):
        own = np.random.default_rng(child)
        rng = np.random.default_rng(seed) if program == "one_sine" else own
        drive = _drive(rig, program, n, first + index, rng)
        duty = roads.duty(n, own)
        if program != "rich":
            duty[:] = held
        motion = Motion(rig, drive, duty, int(own.integers(2**31)))
        motions.append(_scaled(motion, base, rng))
    return motions
