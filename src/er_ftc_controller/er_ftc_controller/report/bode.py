"""Bode diagrams of figures 6.16 and 6.17, and the trade-off of comfort over what the greatest rho may cost."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from er_models.forms.passive import OUTPUTS
from er_models.model import Array
from matplotlib.figure import Figure


def bode_picture(
    path: Path, hertz: Array, passive: Array, ends: Sequence[tuple[str, Array]]
) -> None:
    """Gains from the road to body, wheel and deflection: of the passive car (k, 3), and by name, (k, 3) each."""
    figure = Figure(figsize=(12.0, 4.0), layout="constrained")
    axes = figure.subplots(1, len(OUTPUTS))
    for i, (axis, name) in enumerate(zip(axes, OUTPUTS, strict=True)):
        axis.semilogx(hertz, 20.0 * np.log10(passive[:, i]), color="black", label="passive")
        for label, gains in ends:
            axis.semilogx(hertz, 20.0 * np.log10(gains[:, i]), label=label)
        axis.set(title=f"{name} / z_r", xlabel="frequency [Hz]", ylabel="gain [dB]")
        axis.grid(visible=True, alpha=0.3)
    axes[0].legend()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)


def trade_off_picture(path: Path, rows: Sequence[tuple[float, float, float]]) -> None:
    """Least gamma at the lowest rho over the greatest rho and what gamma may be there; rows (rho, allowance, share)."""
    figure = Figure(figsize=(6.0, 4.0), layout="constrained")
    axis = figure.subplots()
    for allowed in dict.fromkeys(row[1] for row in rows):
        line = [(rho, share) for rho, a, share in rows if a == allowed]
        axis.semilogx(
            *zip(*line, strict=True), marker="o", label=f"gamma at rho_max: {allowed:g} x passive"
        )
    axis.set(xlabel="greatest rho", ylabel="gamma at the lowest rho / passive")
    axis.grid(visible=True, alpha=0.3)
    axis.legend()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
