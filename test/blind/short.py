"""Short records shared by the tests of the effects."""

from __future__ import annotations

from functools import cache

import numpy as np

from test.blind import calibrate, plant
from test.blind.catalogue import BY_NAME
from test.blind.jit import Array


@cache
def short_motion(seed: int, rig: plant.Rig = "car") -> tuple[tuple[plant.Motion, ...], Array]:
    """Two short records and a base, shared by the tests."""
    base = plant.draw_base(np.random.default_rng(seed))
    sequence = np.random.SeedSequence(seed)
    return tuple(plant.draw_motions(rig, "rich", 2, 6.0, base, sequence)), base


@cache
def hidden_alone(name: str, seed: int) -> tuple[calibrate.Hidden, tuple[dict[str, Array], ...]]:
    """One effect calibrated on short records, and those records without noise."""
    motions, base = short_motion(seed)
    scene = calibrate.scene_of(motions, base, 6.0)
    rng = np.random.default_rng([seed, BY_NAME[name].slot])
    one = calibrate.hide(BY_NAME[name], motions, scene, 0.15, rng)
    return one, tuple(calibrate.clean_records(motions, calibrate.table_of([one]), base, 6.0))


@cache
def complete(seed: int) -> tuple[dict[str, Array], ...]:
    """The same short records of the complete model."""
    motions, base = short_motion(seed)
    return tuple(calibrate.clean_records(motions, plant.NO_EFFECT, base, 6.0))
