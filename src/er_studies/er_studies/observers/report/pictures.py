"""One picture per scenario: force and error of everything that ran, on the first road."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from er_models.model import Array
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

_COLOURS = ("#0072b2", "#009e73", "#cc79a7", "#e69f00", "#d55e00")
_PIXELS = 120


def draw(path: Path, title: str, record: Mapping[str, Array], forces: Mapping[str, Array]) -> None:
    """Write road and duty, true and estimated force, and the errors as a PNG; forces by title, each (n,)."""
    figure = Figure(figsize=(11.0, 9.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(4, 1, sharex=True, height_ratios=(1, 1, 2, 2))
    t, true = record["t"], record["damper_force"]
    figure.suptitle(title)
    axes[0].plot(t, 1e3 * record["road"], color="#444444", linewidth=0.8)
    axes[0].set_ylabel("road [mm]")
    axes[1].plot(t, record["duty"], color="#444444", linewidth=0.8, drawstyle="steps-post")
    axes[1].set_ylabel("duty")
    axes[2].plot(t, true, color="#000000", linewidth=1.2, label="true")
    for (name, force), colour in zip(forces.items(), _COLOURS, strict=False):
        axes[2].plot(t, force, color=colour, linewidth=0.8, label=name)
        axes[3].plot(t, force - true, color=colour, linewidth=0.8, label=name)
    axes[2].set_ylabel("force [N]")
    axes[3].set_ylabel("error [N]")
    axes[3].set_xlabel("time [s]")
    late = t >= t[0] + 0.1 * (t[-1] - t[0])
    reach = 1.2 * max(float(abs(force - true)[late].max()) for force in forces.values())
    axes[3].set_ylim(-reach, reach)
    axes[2].legend(loc="upper right", ncols=len(forces) + 1, fontsize="small")
    for axis in axes:
        axis.grid(visible=True, alpha=0.3)
    figure.savefig(path, dpi=_PIXELS, metadata={"Software": None})
