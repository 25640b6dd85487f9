"""A fleet to measure with: units whose values are spread, each with some recordings and some with friction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from er_models.model import Model
from er_records.write import write_parquet

from er_studies.bench.lab.data import record, truth

SPREAD = 0.05
"""Spread of every parameter between units, over its value [1]."""
EVERY = 10
"""Each so many units, one has friction that the model lacks."""


def fleet(model: Model, folder: Path, units: int, recordings: int, seconds: float, seed: int) -> None:
    """Write the recordings, a folder a unit."""
    for number in range(units):
        rng = np.random.default_rng((seed, number))
        own = _spread(model, rng)
        damper = truth(own) if number % EVERY == 0 else own
        place = folder / f"unit{number:04d}"
        place.mkdir(parents=True)
        for k in range(recordings):
            made = record(model, seconds, seed=int(rng.integers(1 << 31)), damper=damper)
            write_parquet(made, place / f"{k}.parquet")


def _spread(model: Model, rng: np.random.Generator) -> Model:
    """The model with its passive part drawn anew: that is what differs most between dampers of one kind."""
    passive = {
        name: value * (1.0 + SPREAD * rng.standard_normal())
        for name, value in model.effects["passive"].items()
    }
    return model.with_effect("passive", passive)
