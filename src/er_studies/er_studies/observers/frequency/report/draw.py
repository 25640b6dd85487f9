"""A figure of frequency responses as a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from er_models.model import Array
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas

from er_studies.observers.frequency.figures import GRIDDING, POLYTOPIC, UNIFIED, Figure
from er_studies.observers.frequency.responses import HERTZ, Response

_STYLES = {UNIFIED: ("#7b3fa0", "-"), POLYTOPIC: ("#0072b2", "-"), GRIDDING: ("#d55e00", "-")}
_SOURCES = {
    "road": "rate of the unknown input [m/s]",
    "noise": "noise [0.01 m/s2]",
    "gate": "difference of the gates",
}
_FLOOR = 1e-12
_UNITS = {"z_def": "m", "z_us - z_r": "m", "f_y": "N", "force": "N"}


def draw(path: Path, figure: Figure, found: list[Response], names: tuple[str, ...]) -> None:
    """Write one figure; the suffix of the path says as what."""
    titles = names if figure.bode else ("largest singular value, all states",)
    rows = 1 + (len(titles) - 1) // 2
    canvas = Canvas(figsize=(11.0, 2.6 + 2.2 * rows), layout="constrained")
    FigureCanvasAgg(canvas)
    canvas.suptitle(f"Figure {figure.number} for ours: error over {_SOURCES[figure.source]}")
    axes = np.atleast_1d(canvas.subplots(rows, min(2, len(titles)), sharex=True)).ravel()
    for i, (axis, title) in enumerate(zip(axes, titles, strict=False)):
        for r in found:
            alone = [other.observer for other in found].count(r.observer) == 1
            _line(axis, r, r.gains[:, i] if figure.bode else r.sigma, "every" if alone else "")
        unit = f" [{_UNITS.get(title, 'm/s')}]" if figure.bode else ""
        axis.set_title(f"{title}{unit}", fontsize="medium")
        axis.set_ylabel("gain [dB]")
        axis.grid(visible=True, which="both", alpha=0.25)
    for axis in axes[len(titles) :]:
        axis.set_axis_off()
    for axis in axes[-2:]:
        axis.set_xlabel("frequency [Hz]")
    axes[0].legend(fontsize="x-small")
    canvas.savefig(path, dpi=120, metadata={"Date": None} if path.suffix == ".svg" else None)


def _line(axis: Axes, r: Response, gain: Array, which: str) -> None:
    """One response; the end of the duty's range is dash-dotted, only the ends are named; which: "every"."""
    colour, style = _STYLES[r.observer]
    ends = bool(which) or r.duty in (0.0, 0.01, 1.0)
    label = f"{r.observer}, {which} duty {'' if which else f'{r.duty:g}'}" if ends else None
    axis.semilogx(
        HERTZ,
        20.0 * np.log10(np.maximum(gain, _FLOOR)),
        color=colour,
        linestyle="-." if r.duty == 1.0 else style,
        linewidth=1.1 if ends else 0.6,
        label=label,
    )
