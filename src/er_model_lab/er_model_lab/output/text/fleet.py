"""What a fleet shows, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from er_model_lab.output.text.units import parameter, short


def suggested(each: Mapping[str, Any]) -> str:
    """What to record next, in words."""
    what = (
        f"what tells {' and '.join(each['between'])} apart" if "between" in each
        else f"what reveals {each['reveal']}" if "reveal" in each else str(each["record"])
    )  # fmt: skip
    return f"{what} ({each['why']})"


def change(each: Mapping[str, Any]) -> str:
    """A change in words."""
    size = parameter([each["change"], each["sd"], ""]).strip()
    if each["form"] == "groups":
        low, high = short(each["low"]), short(each["high"])
        return f"{each['quantity']} in two groups, {size} apart: about {low} and about {high}"
    scale, unit = (1e-3, "km") if each["axis"] == "mileage" else (1.0 / 86400.0, "days")
    forms = {"line": "in a line from", "step": "at once at", "bend": "from"}
    return f"{each['quantity']} by {size} {forms[each['form']]} {each['axis']} {short(each['at'] * scale)} {unit}"
