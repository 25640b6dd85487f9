"""Cost of a diagnosis over the length of the data and over the size of the catalogue, as a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from er_models.cards.panel import WITH, WITHOUT, Curve, Panel
from er_models.cards.picture import drawing

from er_studies.bench.lab.measure import Line


def picture(length: list[Line], number: list[Line], path: Path) -> None:
    """Write an SVG file: processor times as measured, on straight lines through none at all."""
    panels = (
        _panel(length, "length of the data [min]", 60.0),
        _panel(number, "effects tried", 1.0),
    )
    path.write_text(drawing(panels), encoding="utf-8")


def _panel(lines: list[Line], label: str, unit: float) -> Panel:
    """Time over what is varied, and the straight line through zero nearest to it."""
    n = np.array([line.n / unit for line in lines])
    time = np.array([line.processor for line in lines])
    ends = np.array([0.0, n.max()])
    slope = float(np.sum(time * n) / np.sum(n**2))
    return Panel(label, "processor time of a diagnosis [s]", (
        Curve(ends, slope * ends, WITHOUT), Curve(n, time, WITH),
    ))  # fmt: skip
