"""What made the model: one line for each change the lab made to its file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from er_model_lab.output.report.section import Section
from er_model_lab.output.text.units import arrow, newtons
from er_model_lab.output.text.verdict_text import title_of
from er_model_lab.view import View


def section(view: View) -> Section | None:
    """Changes, oldest first; None for a model that the lab never changed."""
    entries = view.result.get("history") or []
    if not entries:
        return None
    return Section(
        "history", "History of the model", facts={"rows": [_row(view, e) for e in entries]}
    )


def change(view: View, e: Mapping[str, Any]) -> str:
    """What was done, in words."""
    added = [title_of(view, str(name)) for name in e.get("added") or ()]
    if added:
        return f"+ {', '.join(added)}"
    return "identified" if "identified" in e else "refitted"


def fall(e: Mapping[str, Any]) -> str:
    """The error before and after, on data never used to choose where there were any."""
    errors = e.get("rmse_held_out") or e.get("rmse") or {}
    if errors.get("before") is None or errors.get("after") is None:
        return ""
    return arrow(errors["before"], errors["after"])


def _row(view: View, e: Mapping[str, Any]) -> dict[str, str]:
    """One line of the table."""
    records = [str(r) for r in e.get("records") or ()]
    data = ", ".join(records[:4]) + (f" and {len(records) - 4} more" if len(records) > 4 else "")
    return {
        "from": str(e.get("from", "")), "change": change(view, e), "fall": fall(e),
        "floor": newtons(e["noise_floor"]) if e.get("noise_floor") is not None else "",
        "verdict": str(e.get("verdict", "")).replace("_", " "), "data": data, "digest": str(e.get("data", ""))[:12],
        "seed": str(e.get("seed", "")), "command": str(e.get("command_line", "")),
    }  # fmt: skip
