"""Cost of a diagnosis over the length of the data and over the size of the catalogue, as a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from er_models.cards.panel import WITH, WITHOUT, Curve, Panel
from er_models.cards.picture import drawing

from er_model_lab.bench.measure import Line


def picture(length: list[Line], number: list[Line], path: Path) -> None:
    """Write an SVG file: processor time and wall time, as measured."""
    panels = (
        _panel(length, "length of the data [min]", 60.0),
        _panel(number, "effects tried", 1.0),
    )
    path.write_text(drawing(panels), encoding="utf-8")


def _panel(lines: list[Line], label: str, unit: float) -> Panel:
    """Both times over what is varied."""
    n = np.array([line.n / unit for line in lines])
    return Panel(label, "time of a diagnosis [s]", (
        Curve(n, np.array([line.processor for line in lines]), WITHOUT),
        Curve(n, np.array([line.wall for line in lines]), WITH),
    ))  # fmt: skip
