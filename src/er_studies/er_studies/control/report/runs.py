"""Pictures of a scenario's first road: road, deflection, force and duty (figures 6.18 to 6.23 for ours)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from er_models.model import Array
from matplotlib.figure import Figure

_ROWS = (
    ("road", 1e3, "road [mm]"),
    ("deflection", 1e3, "deflection [mm]"),
    ("damper_force", 1.0, "damper force [N]"),
    ("duty", 1.0, "duty"),
)


def runs_picture(
    path: Path, title: str, records: Mapping[str, Mapping[str, Array]], begin: float, end: float
) -> None:
    """Records of several controllers on the same road, by name, between two instants [s]."""
    figure = Figure(figsize=(11.0, 9.0), layout="constrained")
    axes = figure.subplots(len(_ROWS), 1, sharex=True)
    for axis, (channel, factor, label) in zip(axes, _ROWS, strict=True):
        shown = dict(list(records.items())[:1]) if channel == "road" else records
        for name, record in shown.items():
            rows = (record["t"] >= begin) & (record["t"] <= end)
            axis.plot(record["t"][rows], factor * record[channel][rows], label=name, linewidth=0.9)
        axis.set(ylabel=label)
        axis.grid(visible=True, alpha=0.3)
    axes[0].set(title=title)
    axes[1].legend(loc="upper right")
    axes[-1].set(xlabel="time [s]")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
