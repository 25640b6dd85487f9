"""Scores `lab identify` on dampers whose parameters are known: ``./er exec python -m test.identify_score --seeds 100``.

Every seed draws noise, phases and starting values up to a factor of three off. Prints Markdown.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from er_common.versions import versions
from er_models.files import load_model
from er_models.model import Model
from er_records.dataset import Dataset
from er_studies.given_out import table

from test.identify_data import TRUTHS, Truth, program

ROOT = Path(__file__).resolve().parents[1]
WRONG = 3.0
"""Largest factor by which a starting value is off."""


@dataclass(frozen=True)
class Estimate:
    """What one seed gave for one parameter; sd is NaN where the data were said not to tell it."""

    name: str
    true: float
    value: float
    sd: float
    status: str


def started(truth: Truth, seed: int, width: float = 0.0) -> Model:
    """The shipped model with every fitted value off by a random factor, kept inside its bounds.

    width: of the smooth switches [m/s] in place of the shipped one; 0 leaves it.
    """
    model = load_model(ROOT / "config" / "dampers" / f"{truth.model}.yaml")
    rng = np.random.default_rng([seed, 1])
    effects = {k: dict(v) for k, v in model.effects.items()}
    for effect, values in effects.items():
        for q in model.catalogue[effect].parameters:
            if q.fitted:
                wrong = values[q.name] * WRONG ** rng.uniform(-1.0, 1.0)
                values[q.name] = float(np.clip(wrong, *model.bounds(effect, q.name)))
        if width and "v_0" in values:
            values["v_0"] = width
    return replace(model, effects=effects)


def estimates(truth: Truth, seed: int, seconds: float, width: float = 0.0) -> list[Estimate]:
    """Identify one seed from wrong starting values."""
    from er_model_lab.identification import identified
    from er_model_lab.identification.present import parameters

    found = parameters(
        identified(Dataset.of(program(truth, seed, seconds)), started(truth, seed, width))
    )
    flat = {name: entry for values in found.values() for name, entry in values.items()}
    return [
        Estimate(n, t, flat[n]["value"], np.nan if flat[n]["sd"] is None else flat[n]["sd"], flat[n]["status"])
        for n, t in truth.values().items()
    ]  # fmt: skip


def rows(runs: list[list[Estimate]]) -> Iterable[tuple[str, ...]]:
    """One row a parameter: truth, bias, deviations claimed and seen, share within three of those claimed."""
    for parts in zip(*runs, strict=True):
        true = parts[0].true
        value, sd = np.array([p.value for p in parts]), np.array([p.sd for p in parts])
        error = value / true - 1.0
        inside = np.abs(value - true) < 3.0 * sd
        weak = np.mean([p.status != "identified" for p in parts])
        yield (
            parts[0].name, f"{true:.5g}", f"{100 * error.mean():+.2f}", f"{100 * np.mean(sd / abs(true)):.2f}",
            f"{100 * error.std(ddof=1):.2f}" if len(parts) > 1 else "-", f"{100 * inside.mean():.0f}",
            f"{100 * weak:.0f}",
        )  # fmt: skip


HEAD = (
    "parameter",
    "truth",
    "bias [%]",
    "sd claimed [%]",
    "sd seen [%]",
    "within 3 sd [%]",
    "weak [%]",
)


def _quiet() -> None:
    """One thread a process, which ends with the one that started it."""
    import numba
    from er_models.orphan import end_with_parent

    end_with_parent()

    numba.set_num_threads(1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10, help="how many, from 1")
    parser.add_argument("--seconds", type=float, default=6.0, help="length of each record")
    parser.add_argument("--width", type=float, default=0.0, help="of the smooth switches [m/s]")
    parser.add_argument("--dampers", nargs="+", default=list(TRUTHS), choices=list(TRUTHS))
    parser.add_argument("--json", type=Path, help="write the tables here")
    given = parser.parse_args()
    seeds = range(1, given.seeds + 1)
    tables = {}
    context = get_context("spawn")
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[name] = "1"
    with ProcessPoolExecutor(os.cpu_count(), context, _quiet) as pool:
        for damper in given.dampers:
            truth, began = TRUTHS[damper], time.monotonic()
            many = len(seeds)
            runs = list(
                pool.map(
                    estimates, [truth] * many, seeds, [given.seconds] * many, [given.width] * many
                )
            )
            each = os.cpu_count() * (time.monotonic() - began) / many
            sys.stdout.write(
                f"\n{truth.model}: seeds 1 to {many}, {each:.0f} s a seed and core, "
                f"version {versions().get('commit', 'unknown')}\n\n"
            )
            tables[truth.model] = list(rows(runs))
            sys.stdout.write(table(HEAD, tables[truth.model]))
            sys.stdout.flush()
    if given.json:
        given.json.write_text(json.dumps(tables, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
