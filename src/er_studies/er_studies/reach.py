"""`./er study reach DATA --model MODEL`: what held-out records leave to those who know more than the model.

Beside the error of the model stand a constant for each steady duty, learnt from the training records; a constant for
each record, which only the record itself can tell; boosted trees on motion, duty and their past; and trees that see the
measured force 20, 40 and 80 ms ago as well. What none of them predicts no model of these inputs does.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from er_model_lab.diagnosis.noise_floor import features
from er_model_lab.problem.problem import Problem
from er_model_lab.verbs.asking import question
from er_model_lab.verbs.load import load, load_model
from er_models.model import Array, Model
from er_records.dataset import Dataset

from er_studies.given_out import Json, Table, give
from er_studies.programs import program_of, run

PAST = (0.02, 0.04, 0.08)
"""How long ago the force is seen [s]."""
ROWS, LEVELS = 20_000, 12
"""Samples that trees learn from, and most steady duties that get a constant each."""


@dataclass(frozen=True)
class Left:
    """What is left: in words what was known, and the root of the mean square [N] of both parts of the records."""

    known: str
    train: float
    held_out: float


def reach(data: Dataset, model: Model, held_out: Dataset | None = None) -> list[Left]:
    """What the records leave to the model and to each that knows more, in the order of the module."""
    asked = question(data, model, held_out=held_out)
    found = asked.level.given(asked)
    problem, left = found.problem, found.given
    inputs = features(problem, problem.force - left)
    past = np.stack([_ago(problem, seconds) for seconds in PAST], axis=1)
    residuals = {
        "the model as it is": left,
        "a constant of each steady duty": left - _by_duty(problem, left),
        "a constant of each record, told by itself": left - _by_record(problem, left),
        "trees on motion, duty and their past": left - _trees(problem, left, inputs),
        "trees that see the force's past": left - _trees(problem, left, np.hstack([inputs, past])),
    }
    return [
        Left(known, *(float(np.sqrt(np.mean(r[part] ** 2))) for part in (problem.train, problem.held_out)))
        for known, r in residuals.items()
    ]  # fmt: skip


def _ago(problem: Problem, seconds: float) -> Array:
    """The measured force some time ago (n,) [N]; at the start of a record its first sample."""
    m, out = problem.motion, np.empty(problem.force.size)
    k = max(round(seconds / m.dt), 1)
    for i, j in pairwise(m.starts.tolist()):
        out[i:j] = np.concatenate(
            [np.full(min(k, j - i), problem.force[i]), problem.force[i : max(j - k, i)]]
        )
    return out


def _by_duty(problem: Problem, left: Array) -> Array:
    """The mean that the training records leave at each duty (n,) [N]; zero where the duty is not steady."""
    duty, out = np.round(problem.motion.u, 3), np.zeros(left.size)
    levels = np.unique(duty)
    for level in levels if levels.size <= LEVELS else ():
        here = duty == level
        rows = here & problem.train
        out[here] = left[rows].mean() if rows.any() else 0.0
    return out


def _by_record(problem: Problem, left: Array) -> Array:
    """The mean that each record leaves (n,) [N]."""
    out = np.zeros(left.size)
    for i, j in pairwise(problem.motion.starts.tolist()):
        used = problem.used[i:j]
        out[i:j] = left[i:j][used].mean() if used.any() else 0.0
    return out


def _trees(problem: Problem, left: Array, inputs: Array) -> Array:
    """What boosted trees, learnt from the training records, predict of what is left (n,) [N]."""
    from sklearn.ensemble import HistGradientBoostingRegressor  # half a second

    rows = np.flatnonzero(problem.train)
    rows = rows[:: max(1, -(-rows.size // ROWS))]
    trees = HistGradientBoostingRegressor(
        max_iter=150, learning_rate=0.08, max_leaf_nodes=12, min_samples_leaf=30, l2_regularization=1.0,
        random_state=1,
    )  # fmt: skip
    return np.asarray(trees.fit(inputs[rows], left[rows]).predict(inputs))


def reach_command(
    data: Annotated[list[Path], typer.Argument(help="Records that are learnt from.")],
    model: Annotated[Path, typer.Option("--model", help="Model file.")],
    hold_out: Annotated[
        list[Path] | None, typer.Option("--hold-out", help="Records that only score.")
    ] = None,
    json_file: Json = None,
) -> None:
    """Say what held-out records leave to a model, to constants, and to trees with and without the force's past."""
    found = reach(load(*data), load_model(model), load(*hold_out) if hold_out else None)
    rows = [(each.known, f"{each.train:.3g}", f"{each.held_out:.3g}") for each in found]
    give([Table(("known", "training [N]", "held out [N]"), rows)], json_file)


app = program_of(reach_command)

if __name__ == "__main__":
    run(app)
