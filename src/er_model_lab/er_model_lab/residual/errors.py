"""Errors of a prediction, and the regions that carry most of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray

from er_model_lab.problem.problem import Problem
from er_model_lab.residual.region import Region, RegionTable

ANOTHER_SIZE = 5.0
"""Factor between measured and predicted force beyond which the model is that of another damper, or a unit is wrong."""
ALIKE = 0.25
"""Share of the measured force that the predicted one must explain at any size before their sizes are compared."""


@dataclass(frozen=True)
class Errors:
    """Errors over a mask: root mean square [N], and over the range of the measured force (3.79)."""

    rmse: float
    nrmse: float


def explainable(mse: float, floor: float) -> float:
    """Share [1] of a mean square error [N2] that is beyond the noise floor [N]."""
    return max(1.0 - floor**2 / mse, 0.0) if mse > 0.0 else 0.0


def errors(problem: Problem, residual: Array, mask: NDArray[np.bool_]) -> Errors:
    """RMSE [N] and NRMSE = RMSE / (max - min of the force), thesis (3.79)-(3.80); of the first output."""
    n = problem.forward.outputs
    y, e, mask = problem.force[::n], residual[::n], mask[::n]
    rmse = float(np.sqrt(np.mean(e[mask] ** 2))) if mask.any() else float("nan")
    span = float(np.ptp(y[mask])) if mask.any() else float("nan")
    return Errors(rmse, rmse / span if span > 0 else float("nan"))


def size_notes(problem: Problem, residual: Array) -> tuple[str, ...]:
    """What to think of a measured force of quite another size than the predicted one; empty where it is alike.

    residual (n,): measured minus predicted [N]. The factor is the one by which predicted forces come closest.
    """
    y, mask = problem.force, problem.used
    p = y - residual
    square = float(np.sum(p[mask] ** 2))
    factor = float(np.sum(p[mask] * y[mask])) / square if square > 0.0 else 1.0
    alike = factor**2 * square > ALIKE * float(np.sum(y[mask] ** 2))
    if not alike or 1.0 / ANOTHER_SIZE < factor < ANOTHER_SIZE:
        return ()
    said = f"the measured force is {factor:.2g} times the predicted one: a damper of another size (lab identify)"
    return (f"{said}, or of another unit or sign (lab check)",)


def worst(tables: tuple[RegionTable, ...], most: int = 8) -> list[dict[str, object]]:
    """The region of each quantity that carries far more error than its share of samples, heaviest first."""
    heavy = [
        [r for r in t.regions if r.share > 1.3 * r.of_samples and r.share > 0.05] for t in tables
    ]
    regions = [max(group, key=lambda r: r.share - r.of_samples) for group in heavy if group]
    regions.sort(key=lambda r: r.share - r.of_samples, reverse=True)
    return [region_json(r) for r in regions[:most]]


def region_json(r: Region) -> dict[str, object]:
    """A region as plain data."""
    return {
        "quantity": r.quantity, "unit": r.unit, "from": r.edges[0], "to": r.edges[1], "share": r.share,
        "of_samples": r.of_samples, "rmse": r.rms, "band": list(r.band), "noise": r.floor, "excess": r.excess,
        "excess_band": list(r.excess_band),
    }  # fmt: skip


def regions_json(tables: tuple[RegionTable, ...]) -> dict[str, list[dict[str, object]]]:
    """All regions by quantity."""
    return {t.quantity: [region_json(r) for r in t.regions] for t in tables}
