"""Cost over samples and over effects, as a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from er_models.cards.panel import WITH, WITHOUT, Curve, Panel
from er_models.cards.picture import drawing

from er_studies.bench.models.timing import Line


def picture(length: list[Line], number: list[Line], path: Path) -> None:
    """Write an SVG file: measured times, and the straight lines nearest to them."""
    panels = (
        _panel(length, 1e-3, "samples [thousands]"),
        _panel(number, 1.0, "effects beyond the core"),
    )
    path.write_text(drawing(panels), encoding="utf-8")


def _panel(lines: list[Line], unit: float, label: str) -> Panel:
    """Time [ms] over what is counted."""
    n = np.array([unit * line.n for line in lines])
    time = np.array([1e3 * line.seconds for line in lines])
    basis = np.column_stack([np.ones(n.size), n]) / time[:, None]
    straight = np.linalg.lstsq(basis, np.ones(n.size), rcond=None)[0]
    ends = np.array([0.0, n.max()])
    return Panel(label, "time of a prediction [ms]", (
        Curve(ends, straight[0] + straight[1] * ends, WITHOUT), Curve(n, time, WITH),
    ))  # fmt: skip
