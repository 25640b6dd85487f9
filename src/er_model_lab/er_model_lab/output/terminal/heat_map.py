"""A map of the error in characters: where over velocity and deflection a model fails."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from rich.console import RenderableType

from er_model_lab.output.report.samples import rms_map, samples
from er_model_lab.output.terminal.markup import Pen
from er_model_lab.output.text.units import newtons, short
from er_model_lab.view import Array, View

ROWS, MOST_COLUMNS, LABEL = 7, 36, 7
SHADES, PLAIN = (
    "\N{MIDDLE DOT}\N{LIGHT SHADE}\N{MEDIUM SHADE}\N{DARK SHADE}\N{FULL BLOCK}",
    ".:+#@",
)
"""From little error to much, on a terminal and elsewhere; a blank was never visited."""
TOP = 0.98
"""Quantile of the tiles that gets the darkest shade."""


def heat_map(view: View, pen: Pen) -> Iterator[RenderableType]:
    """Rms residual over velocity and deflection: of one model, or before and after side by side on one scale."""
    s = samples(view.records)
    if s is None:
        return
    columns = min((pen.width - LABEL) // len(s.models) - 4, MOST_COLUMNS)
    maps = [
        rms_map(1e3 * s.velocity, 1e3 * s.deflection, s.measured - force, (columns, ROWS))
        for _, force in s.models
    ]
    peak = max(
        (float(np.nanquantile(z, TOP)) for *_, z in maps if np.isfinite(z).any()), default=0.0
    )
    if not peak > 0.0:
        return
    (x, y, _), names = maps[0], [name.removeprefix("model ") for name, _ in s.models]
    sides = "" if len(names) < 2 else f"; {' | '.join(names)}"
    shades = PLAIN if pen.plain else SHADES
    yield pen.line("")
    yield pen.line(
        f"rms error {shades[0]} 0 to {shades[-1]} {newtons(peak)} over velocity and deflection{sides}"
    )
    for k in range(ROWS)[::-1]:
        label = f"{short(float(y[k + 1] if k else y[0]), 2)} mm" if k in (0, ROWS - 1) else ""
        drawn = " ".join(f"|{_row(z[k], peak, shades)}|" for *_, z in maps)
        yield pen.whole(f"{label:>{LABEL}} {drawn}")
    low, high = f"{short(float(x[0]), 2)} mm/s", f"{short(float(x[-1]), 2)} mm/s"
    yield pen.whole(
        " " * (LABEL + 1) + (f"{low}{high:>{columns + 2 - len(low)}} " * len(maps)).rstrip()
    )


def _row(z: Array, peak: float, shades: str) -> str:
    """One row of tiles (n,) as characters; NaN is blank."""
    level = np.clip(np.nan_to_num(z) / peak * len(shades), 0, len(shades) - 1).astype(int)
    return "".join(shades[i] if np.isfinite(v) else " " for i, v in zip(level, z, strict=True))
