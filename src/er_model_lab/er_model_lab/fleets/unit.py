"""One unit by itself: all that was recorded of one damper, and what the model lacks there."""

from __future__ import annotations

import pickle
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from er_models.errors import ErError
from er_records.dataset import Dataset
from er_records.load import load
from er_records.provenance import content_digest
from er_records.record import Record

from er_model_lab.fleets.asked import Asked
from er_model_lab.fleets.places import Unreachable, local
from er_model_lab.results.result import DiagnosisResult, Result
from er_model_lab.results.values import clean, parameters
from er_model_lab.verbs.diagnose import diagnose

MOST_SAMPLES = 2_000_000
"""Samples of a unit that are held at once, at most: some 150 MB."""


@dataclass(frozen=True)
class UnitJob:
    """A unit to diagnose: its recordings, and by their content the records in them that count.

    samples: of all of them; keeps: whether what a page shows is wanted with the row; seen: that of the diagnosis, b""
    where it was not kept.
    """

    unit: str
    paths: tuple[str, ...]
    digests: frozenset[str]
    samples: int = 0
    keeps: bool = False
    seen: bytes = b""


def chosen(samples: Sequence[int], most: int) -> list[int]:
    """Places of the recordings that a unit is diagnosed with, in the order of time: spread evenly, ends included.

    samples: of each; most: recordings at most. The sum stays below `MOST_SAMPLES`, but one is always taken.
    """
    for n in range(min(len(samples), most), 1, -1):
        places = sorted({round(k) for k in np.linspace(0, len(samples) - 1, n)})
        if sum(samples[k] for k in places) <= MOST_SAMPLES:
            return places
    return [len(samples) - 1] if samples else []


def unit(job: UnitJob, asked: Asked) -> tuple[dict[str, Any], bytes]:
    """The row of a unit: verdict, effects, errors [N], values of the best model, what to record next.

    With it comes what `page` needs, b"" unless the job keeps it.
    """
    result = diagnosed(job, asked)
    found = result.to_dict()
    row: dict[str, Any] = clean({
        "verdict": found["verdict"], "effects": found["effects"], "alternatives": found["alternatives"],
        "rmse": found["rmse"]["held_out"], "rmse_after": found["rmse_after"]["held_out"],
        "nrmse": found["nrmse"]["held_out"], "rmse_as_given": found["rmse_as_given"],
        "noise_floor": found["noise_floor"], "explainable": found["explainable"], "values": values(result),
        "candidates": {
            c["effect"]: [c["evidence"], c.get("threshold"), c["p_value"], c["status"]] for c in found["candidates"]
        },
        "next": found["next_plans"], "hints": found["coverage"]["hints"], "reasons": found["reasons"],
        "notes": found["notes"],
    })  # fmt: skip
    return row, zlib.compress(pickle.dumps(result.view)) if job.keeps else b""


def diagnosed(job: UnitJob, asked: Asked) -> DiagnosisResult:
    """The diagnosis of a unit's recordings.

    Raises:
        ErError: They are not fit for it.
        Unreachable: They cannot be had now, or are others by now.
    """
    return diagnose(_data(job), asked.model, seed=asked.seed, rule=asked.rule, anyway=asked.anyway)


def values(found: DiagnosisResult) -> dict[str, list[Any]]:
    """Values of the best model: {effect.name: [value, deviation, unit]}."""
    model = found.model
    assert model is not None
    return {
        f"{effect}.{name}": triple
        for effect in model.effects for name, triple in parameters(model, effect).items()
    }  # fmt: skip


def page(job: UnitJob, asked: Asked) -> bytes:
    """The report of a unit's diagnosis as one page."""
    result = Result(pickle.loads(zlib.decompress(job.seen))) if job.seen else diagnosed(job, asked)
    with TemporaryDirectory(prefix="er_fleet_") as folder:
        return result.report(folder).read_bytes()


def _data(job: UnitJob) -> Dataset:
    """The records of a unit, each once; they were read before, so that what fails now is no answer."""
    found: dict[str, Record] = {}
    try:
        for path in job.paths:
            with local(path) as place:
                for record in load([place]):
                    if (digest := content_digest(record)) in job.digests:
                        found.setdefault(digest, record)
    except ErError as error:
        raise Unreachable(str(error)) from None
    if missing := len(job.digests - found.keys()):
        raise Unreachable(
            f"records of {job.unit} changed since they were first read ({missing} of {len(job.digests)})"
        )
    return Dataset.of(list(found.values()))
