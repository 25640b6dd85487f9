"""What the motion rests on: channels, what they leave unknown, and the bias of each accelerometer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from er_model_lab.output.report.section import Section
from er_model_lab.output.text.units import factor, short, shown
from er_model_lab.view import View

UNITS = {"deflection": "m", "velocity": "m/s", "acceleration": "m/s2"}
BIAS = {
    "sprung_acceleration": "bias of the sprung acceleration",
    "unsprung_acceleration": "bias of the unsprung acceleration",
    "relative": "bias of their difference",
}  # fmt: skip
"""Plain names of the biases."""


def section(view: View) -> Section | None:
    """Table of the fused motion; None where no motion was fused."""
    found = view.result.get("fusion")
    if not found:
        return None
    rows = [
        (name, _size(found["noise"][name], unit), _size(found["sd"][name], unit))
        for name, unit in UNITS.items()
    ]
    bias = [(BIAS[name], _bias(e), e["says"]) for name, e in found["bias"].items()]
    channels = ", ".join(c.replace("_", " ") for c in found["channels"])
    return Section(
        "motion",
        "The motion",
        facts={"rows": rows, "bias": bias, "lost": found["lost"], "channels": channels},
    )


def _size(value: float | None, unit: str) -> str:
    """A standard deviation in the unit shown; a dash where the channel is absent."""
    return f"{short(value * factor(unit))} {shown(unit)}" if value is not None else "-"


def _bias(e: Mapping[str, Any]) -> str:
    """A bias with its deviation."""
    if e["value"] is None:
        return "-"
    return f"{e['value']:+.4f} \N{PLUS-MINUS SIGN} {short(e['sd'], 2)} m/s2".replace(
        "-", "\N{MINUS SIGN}"
    )
