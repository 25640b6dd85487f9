"""The check on all of long data: what the models leave where nothing was searched."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from er_models.model import Array, Model
from er_models.prediction import predict
from er_records.dataset import Place
from numpy.typing import NDArray

from er_model_lab.problem.held_out import WARM_UP
from er_model_lab.problem.stretches import places_of
from er_model_lab.residual.errors import explainable
from er_model_lab.span.whole_record import WholeRecords, first_row

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

    whole: WholeRecords
    left: dict[str, Array]
    places: list[Place]
    searched: NDArray[np.bool_]
    square: Array
    held_out: float
    learn: int

    @property
    def used(self) -> NDArray[np.bool_]:
        """Samples (N,) that count: after the warm-up of each record, wild ones aside."""
        motion = self.whole.motion
        used = ~self.whole.wild
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

    def as_json(self, *, again: bool) -> dict[str, Any]:
        """What was searched, and the errors on all data [N]; again: the search was repeated."""
        whole, dt = self.whole, self.whole.motion.dt
        masks = {"all": self.used, "elsewhere": self.elsewhere}
        order = np.argsort(-self.square, kind="stable")[:SHOWN]
        return {
            "seconds": whole.motion.n * dt,
            "searched_seconds": float(whole.rows.size * dt),
            "records": len(whole.data),
            "searched": [self._stretch(int(k)) for k in np.flatnonzero(self.searched)],
            "searched_again": again,
            "rmse": {
                name: {
                    where: rms(left[mask]) if mask.any() else None for where, mask in masks.items()
                }
                for name, left in self.left.items()
            },
            "worst": [
                {
                    **self._stretch(int(k)),
                    "rmse": float(np.sqrt(self.square[k])),
                    "searched": bool(self.searched[k]),
                }
                for k in order
            ],
        }

    def _stretch(self, k: int) -> dict[str, Any]:
        """Record of a stretch, and where it begins and ends in it [s]."""
        p = self.places[k]
        t = self.whole.data[p.record].t
        since, until = float(t[p.i] - t[0]), float(t[p.j - 1] - t[0])
        return {"record": self.whole.data[p.record].name, "from": since, "to": until}

    def errors(self, floor: float) -> dict[str, Any]:
        """Errors [N] of the last model on all data, as `compare` gives them; floor [N]: what noise leaves."""
        left, used = self.left_now, self.used
        error, span = rms(left[used]), float(np.ptp(self.whole.force[used]))
        return {
            "rmse": error,
            "nrmse": error / span if span > 0.0 else float("nan"),
            "explainable": explainable(error**2, floor),
            "rmse_by_record": {name: rms(left[cut][used[cut]]) for name, cut in self.records},
        }

    def note(self, *, again: bool) -> str:
        """One sentence on what was used of long data."""
        found = self.as_json(again=again)
        error = list(found["rmse"].values())[-1]
        rest = (
            ""
            if error["elsewhere"] is None
            else f", {error['elsewhere']:.3g} N where nothing was searched"
        )
        worst = ", the worst of the rest among them" if again else ""
        return (
            f"{found['searched_seconds']:.0f} of {found['seconds']:.0f} s searched; on all {error['all']:.3g} N{rest} "
            f"({len(found['searched'])} stretches that cover what the data hold{worst})"
        )


def rms(y: Array) -> float:
    """Root mean square of samples."""
    return float(np.sqrt(np.mean(y**2)))


def checked(whole: WholeRecords, held_out: Array, **models: Model) -> Checked:
    """Predict whole records with each model; held_out: what the last one leaves of the samples that score it [N]."""
    left = {
        name: whole.force - predict(model, whole.motion, whole.told)
        for name, model in models.items()
    }
    places = places_of(whole.data)
    inside = np.zeros(whole.motion.n, bool)
    inside[whole.rows] = True
    searched, square, last = [], [], list(left.values())[-1]
    for p in places:
        i = first_row(whole.motion, whole.data, p.record, p.i)
        j = first_row(whole.motion, whole.data, p.record, p.j - 1) + 1
        i += round(WARM_UP / whole.motion.dt) if p.i == 0 else 0
        searched.append(bool(inside[i:j].mean() > 0.5))
        kept = last[i:j][~whole.wild[i:j]]
        square.append(float(np.mean(kept**2)) if kept.size else 0.0)
    held = float(np.mean(held_out**2))
    return Checked(whole, left, places, np.array(searched), np.array(square), held, whole.learn)
