"""The check on all of long data: what the models leave where nothing was searched."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from er_models.model import Array, Model
from er_models.predict import predict
from numpy.typing import NDArray

from er_model_lab.long.whole_record import LongForward, Whole, first_row
from er_model_lab.problem.held_out import WARM_UP
from er_model_lab.problem.problem import Problem
from er_model_lab.problem.stretches import Place, places_of
from er_model_lab.residual.errors import explainable

WORSE = 1.15
"""Error elsewhere, over that on the held-out stretches, from which the search is repeated with the worst of it."""
AGAIN = 6
"""Stretches that such a repetition takes in."""
SHOWN = 5
"""Stretches that are named."""


@dataclass(frozen=True)
class Checked:
    """What models leave on all of the data.

    left: per model ("before", "after") the residual (N,) [N]; places: all stretches; searched: which of them were
    searched; square: mean square (stretches,) [N2] that the last model leaves in each; held_out: that on the
    held-out samples of the search, or where none are on those it learnt from; learn: how many records may be
    learnt from.
    """

    whole: Whole
    left: dict[str, Array]
    places: list[Place]
    searched: NDArray[np.bool_]
    square: Array
    held_out: float
    learn: int

    @property
    def used(self) -> NDArray[np.bool_]:
        """Samples (N,) that count: after the warm-up of each record."""
        motion = self.whole.motion
        used = np.ones(motion.n, bool)
        for i in motion.starts[:-1]:
            used[i : i + round(WARM_UP / motion.dt)] = False
        return used

    @property
    def records(self) -> list[tuple[str, slice]]:
        """Name and rows of every record."""
        cuts = (slice(int(i), int(j)) for i, j in pairwise(self.whole.motion.starts))
        return list(zip((r.name for r in self.whole.data), cuts, strict=True))

    @property
    def elsewhere(self) -> NDArray[np.bool_]:
        """Samples (N,) that count and were not searched."""
        mask = self.used
        mask[self.whole.rows] = False
        return mask

    @property
    def missed(self) -> list[Place]:
        """Stretches to search as well, worst first; none where the model does as well elsewhere."""
        order = [
            int(k)
            for k in np.argsort(-self.square, kind="stable")
            if not self.searched[k] and self.places[k].record < self.learn
        ]
        rest = np.mean(self.left_now[self.elsewhere] ** 2) if self.elsewhere.any() else 0.0
        if rest < WORSE**2 * self.held_out:
            return []
        return [self.places[k] for k in order[:AGAIN] if self.square[k] > WORSE**2 * self.held_out]

    @property
    def left_now(self) -> Array:
        """Residual (N,) of the last model [N]."""
        return list(self.left.values())[-1]


def checked(problem: Problem, residual: Array, **models: Model) -> Checked | None:
    """Predict all of the data with each model; None where the data were searched whole.

    residual: (n,) of the last model on the samples searched [N].
    """
    forward = problem.forward
    if not isinstance(forward, LongForward):
        return None
    whole = forward.whole
    left = {name: whole.force - predict(model, whole.motion) for name, model in models.items()}
    places = places_of(whole.data)
    inside = np.zeros(whole.motion.n, bool)
    inside[whole.rows] = True
    searched, square, last = [], [], list(left.values())[-1]
    for p in places:
        i = first_row(whole.motion, whole.data, p.record, p.i)
        j = first_row(whole.motion, whole.data, p.record, p.j - 1) + 1
        i += round(WARM_UP / whole.motion.dt) if p.i == 0 else 0
        searched.append(bool(inside[i:j].mean() > 0.5))
        square.append(float(np.mean(last[i:j] ** 2)))
    score = problem.held_out if problem.held_out.any() else problem.train
    held = float(np.mean(residual[score] ** 2))
    return Checked(whole, left, places, np.array(searched), np.array(square), held, whole.learn)


def long_json(found: Checked, *, again: bool) -> dict[str, Any]:
    """What was searched of long data, and the errors on all of them [N]; again: the search was repeated."""
    whole, dt = found.whole, found.whole.motion.dt
    rows, n = whole.rows, whole.motion.n
    masks = {"all": found.used, "elsewhere": found.elsewhere}

    def stretch(k: int) -> dict[str, Any]:
        p = found.places[k]
        t = whole.data[p.record].t
        since, until = float(t[p.i] - t[0]), float(t[p.j - 1] - t[0])
        return {"record": whole.data[p.record].name, "from": since, "to": until}

    order = np.argsort(-found.square, kind="stable")[:SHOWN]
    return {
        "seconds": n * dt,
        "searched_seconds": float(rows.size * dt),
        "records": len(whole.data),
        "searched": [stretch(int(k)) for k in np.flatnonzero(found.searched)],
        "searched_again": again,
        "rmse": {
            name: {
                where: float(np.sqrt(np.mean(left[mask] ** 2))) if mask.any() else None
                for where, mask in masks.items()
            }
            for name, left in found.left.items()
        },
        "worst": [
            {
                **stretch(int(k)),
                "rmse": float(np.sqrt(found.square[k])),
                "searched": bool(found.searched[k]),
            }
            for k in order
        ],
    }


def errors_json(found: Checked, floor: float) -> dict[str, Any]:
    """Errors [N] of the last model on all of long data, as `compare` gives them; floor [N]: what noise leaves."""
    left, used = found.left_now, found.used
    force = found.whole.force[used]
    rmse, span = float(np.sqrt(np.mean(left[used] ** 2))), float(np.ptp(force))
    return {
        "rmse": rmse,
        "nrmse": rmse / span if span > 0.0 else float("nan"),
        "explainable": explainable(rmse**2, floor),
        "rmse_by_record": {
            name: float(np.sqrt(np.mean(left[cut][used[cut]] ** 2))) for name, cut in found.records
        },
    }


def long_note(found: dict[str, Any]) -> str:
    """One sentence on what was used of long data."""
    error = list(found["rmse"].values())[-1]
    rest = (
        ""
        if error["elsewhere"] is None
        else f", {error['elsewhere']:.3g} N where nothing was searched"
    )
    worst = ", the worst of the rest among them" if found["searched_again"] else ""
    return (
        f"{found['searched_seconds']:.0f} of {found['seconds']:.0f} s searched; on all {error['all']:.3g} N{rest} "
        f"({len(found['searched'])} stretches that cover what the data hold{worst})"
    )


def told(problem: Problem, residual: Array, **models: Model) -> tuple[Problem, dict[str, Any]]:
    """A problem with a note of what was used of long data, and `long` for the JSON; as it is where all was.

    residual, models: see `checked`.
    """
    found = checked(problem, residual, **models)
    if found is None:
        return problem, {}
    long = long_json(found, again=False)
    return replace(problem, notes=(long_note(long), *problem.notes)), {"long": long}
