"""Several models on the same data: their errors, and how sure the difference between them is.

The difference of two mean squares is taken sample by sample, and its band from one-second blocks drawn again, so
that noise and motion which both models share do not count.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from er_models.model import Array, Model
from numpy.typing import NDArray

from er_model_lab.residual.errors import explainable
from er_model_lab.residual.excess import BOOTSTRAPS
from er_model_lab.residual.region import RegionTable
from er_model_lab.span.check import Checked
from er_model_lab.view import RecordView


@dataclass(frozen=True)
class Rival:
    """A model, what it predicts (`before` of each record), and whether it was fitted to these data.

    whole: what it leaves of long data, of which `records` are stretches.
    """

    model: Model
    records: tuple[RecordView, ...]
    fitted_here: bool
    regions: tuple[RegionTable, ...] = ()
    whole: Checked | None = None


def fitted_to(model: Model, data: str) -> bool:
    """Whether a model's history names data with this fingerprint."""
    return any(entry.get("data") == data for entry in model.history)


def names(rivals: Sequence[Rival]) -> tuple[str, ...]:
    """Names of the models, those that share one told apart by their files, or by their number."""
    own = [r.model.name for r in rivals]
    own = [
        f"{n} ({r.model.file})" if own.count(n) > 1 else n
        for n, r in zip(own, rivals, strict=True)
    ]
    return tuple(f"{n} #{k + 1}" if own.count(n) > 1 else n for k, n in enumerate(own))


def overlaid(rivals: Sequence[Rival]) -> tuple[RecordView, ...]:
    """Records of the first model with what the others predict."""
    called = names(rivals)
    return tuple(
        replace(
            first, others=tuple((n, o.before) for n, o in zip(called[1:], others, strict=True))
        )
        for first, *others in zip(*(r.records for r in rivals), strict=True)
    )


def table(rivals: Sequence[Rival], floor: float, seed: int) -> list[dict[str, Any]]:
    """One entry per model: errors, share of its error that is the model's, and the fall against the first."""
    runs = [_runs(rival) for rival in rivals]
    first, span = _squares(runs[0]), _span(runs[0])
    rng = np.random.default_rng(seed)
    picks = rng.integers(0, first.shape[0], (BOOTSTRAPS, first.shape[0]))
    out = []
    for called, rival, own in zip(names(rivals), rivals, runs, strict=True):
        sums = _squares(own)
        mse = float(sums[:, 0].sum() / sums[:, 1].sum())
        again = _rms(sums, picks) - _rms(first, picks)
        low, high = np.quantile(again, [0.05, 0.95])
        rmse = float(np.sqrt(mse))
        out.append({
            "model": called, "model_file": rival.model.file, "rmse": rmse, "nrmse": rmse / span if span > 0.0 else None,
            "explainable": explainable(mse, floor),
            "against_first": {"change": float(rmse - np.sqrt(first[:, 0].sum() / first[:, 1].sum())),
                              "band": [float(low), float(high)]},
            "rmse_by_record": {run.name: _error(run) for run in own},
            "fitted_to_these_data": rival.fitted_here, "effects": list(rival.model.effects),
        })  # fmt: skip
    return out


@dataclass(frozen=True)
class _Run:
    """One record: its sample time [s], measured force and what the model leaves of it (n,) [N], and what is scored."""

    name: str
    dt: float
    measured: Array
    left: Array
    scored: NDArray[np.bool_]


def _runs(rival: Rival) -> list[_Run]:
    """The records as they are scored: long ones from beginning to end."""
    if rival.whole is None:
        return [
            _Run(r.name, float(np.median(np.diff(r.t))), r.measured, r.measured - r.before, r.scored)
            for r in rival.records
        ]  # fmt: skip
    found, whole = rival.whole, rival.whole.whole
    left, used = found.left_now, found.used
    return [
        _Run(name, whole.motion.dt, whole.force[cut], left[cut], used[cut])
        for name, cut in found.records
    ]


def _squares(runs: Sequence[_Run]) -> Array:
    """Sum of squares and number of samples (blocks, 2) of one-second blocks of the scored samples."""
    parts = []
    for r in runs:
        block = np.arange(r.left.size) // max(round(1.0 / r.dt), 1)
        squared = np.where(r.scored, r.left**2, 0.0)
        parts.append(np.stack([np.bincount(block, squared), np.bincount(block, r.scored)], axis=1))
    return np.concatenate(parts)


def _rms(sums: Array, picks: NDArray[np.int64]) -> Array:
    """Root mean square error over blocks drawn again (draws,)."""
    return np.asarray(
        np.sqrt(sums[picks, 0].sum(axis=1) / np.maximum(sums[picks, 1].sum(axis=1), 1.0))
    )


def _error(r: _Run) -> float:
    """Root mean square error of a record."""
    return float(np.sqrt(np.mean(r.left[r.scored] ** 2))) if r.scored.any() else 0.0


def _span(runs: Sequence[_Run]) -> float:
    """Range of the measured force over the scored samples [N]."""
    force = np.concatenate([r.measured[r.scored] for r in runs])
    return float(np.ptp(force)) if force.size else 0.0
