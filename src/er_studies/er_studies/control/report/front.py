"""Deflection against comfort of several controllers: the nearer to the lower left, the better."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from er_studies.control.contest import Line


def front_picture(path: Path, lines: Sequence[Line]) -> None:
    """Mean changes against the passive car, one panel for each kind of road and fault; tyre load by the colour."""
    panels = list(dict.fromkeys((line.kind, line.fault) for line in lines))
    figure = Figure(figsize=(12.0, 3.8 * ((len(panels) + 1) // 2)), layout="constrained")
    axes = figure.subplots((len(panels) + 1) // 2, 2, squeeze=False).ravel()
    for axis, (kind, fault) in zip(axes, panels, strict=False):
        here = [line for line in lines if (line.kind, line.fault) == (kind, fault)]
        for line in here:
            x, y, tyre = (100.0 * float(v) for v in line.change[:3])
            ours = line.name == "fault_tolerant"
            axis.scatter(
                x,
                y,
                s=90 if ours else 40,
                marker="*" if ours else "o",
                color="C3" if ours else "C0",
            )
            axis.annotate(
                f"{line.name} ({tyre:+.1f})",
                (x, y),
                fontsize=7,
                xytext=(3, 3),
                textcoords="offset points",
            )
        axis.axhline(0.0, color="0.6", linewidth=0.8)
        axis.axvline(0.0, color="0.6", linewidth=0.8)
        axis.set(
            title=f"{kind}, {fault} (tyre load in brackets)",
            xlabel="deflection [%]",
            ylabel="comfort [%]",
        )
        axis.grid(visible=True, alpha=0.3)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
