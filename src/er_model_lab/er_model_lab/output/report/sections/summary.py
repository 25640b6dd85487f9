"""The errors before and after as a table, and record by record."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_model_lab.output.report.section import Section
from er_model_lab.output.text.units import newtons, percent, quantity
from er_model_lab.view import RecordView, View

MOST_RECORDS = 25
"""Records listed; beyond, the worst of them."""
GROWN = {
    "as given": "rmse_as_given",
    "refitted": "rmse",
    "after": "rmse_after",
    "noise": "noise_floor",
}
COMPARED = {"rms error": "rmse", "over its standard deviation": "relative", "white noise": "noise"}
"""Columns of the errors of a car's outputs: of a model that was refitted, and of one as it is."""


def section(view: View) -> Section | None:
    """Table of errors; None when the result holds none."""
    result = view.result
    if result.get("rmse") is None:
        return None
    return Section(
        "summary",
        "Errors",
        facts={
            "head": [name for name, _ in _columns(result)],
            "rows": _rows(result),
            "compared": "rmse_after" in result,
            "own": _own(result),
            "split": isinstance(result["rmse"], Mapping),
            "explained": percent(result["explained"]) if result.get("explained") else "",
            "explainable": percent(result.get("explainable")),
            "noise": _noise(result),
            "records": _records(view),
            "channels": _channels(result),
        },
    )


def _own(result: Mapping[str, Any]) -> str:
    """Name of the model before anything is added."""
    if "rmse_after" not in result:
        return "model"
    return "refitted" if "rmse_as_given" in result else "before"


def _columns(result: Mapping[str, Any]) -> list[tuple[str, dict[str, float]]]:
    """Models in the order in which they were made, then the noise: the error of each by the data it belongs to."""
    given = {"held_out": result.get("rmse_as_given"), "train": result.get("rmse_as_given_train")}
    own = _own(result)
    part = "held_out" if "held_out" in _split(result["rmse"]) else [*_split(result["rmse"])][-1]
    noise = {part: result.get("noise_floor")}
    noise |= {"train": result.get("noise_floor_train")} if part != "train" else {}
    found = [
        ("as given", _split(given)), (own, _split(result["rmse"])), ("after", _split(result.get("rmse_after"))),
        ("noise", _split(noise)),
    ]  # fmt: skip
    return [(name, values) for name, values in found if values]


def _rows(result: Mapping[str, Any]) -> list[tuple[str, list[str]]]:
    """The data, and the error of each model on them; the same over the range of the measured force."""
    names = {"train": "training data", "held_out": "held-out data", "all": "all data"}
    columns, errors, relative = (
        _columns(result),
        _split(result["rmse"]),
        _split(result.get("nrmse")),
    )
    rows = [
        (f"rms error, {names[part]}", [newtons(values.get(part)) for _, values in columns])
        for part in errors
    ]
    for part, share in relative.items():
        # all have the same range of the measured force below them
        scale = share / errors[part] if errors.get(part) else float("nan")
        shares = [percent(scale * v[part]) if part in v else "-" for _, v in columns]
        rows.append((f"NRMSE, {names[part]}", shares))
    return rows


def _split(value: object) -> dict[str, float]:
    """An error as the result states it: by part, or one number for all data."""
    if value is None:
        return {}
    parts: Mapping[Any, Any] = value if isinstance(value, Mapping) else {"all": value}
    return {str(k): float(v) for k, v in parts.items() if v is not None}


def _noise(result: Mapping[str, Any]) -> str:
    """Where the noise comes from, in a clause."""
    noise = result.get("noise") or {}
    force, inputs = noise.get("force_white"), noise.get("input_error")
    if force is None or inputs is None:
        return ""
    force, inputs = newtons(force), newtons(inputs)
    return f"white noise of the force {force}, errors of the motion sensors {inputs}"


def _channels(result: Mapping[str, Any]) -> dict[str, Any]:
    """Heads and rows of the errors of each output of a car, in its own unit: of each model, or over its own size."""
    channels = result.get("channels") or {}
    grown = any("rmse_after" in c for c in channels.values())
    keys = GROWN if grown else COMPARED
    rows = [
        (name.replace("_", " "), [
            percent(c.get(key)) if key == "relative" else quantity(c.get(key), str(c.get("unit", "")))
            for key in keys.values()
        ])
        for name, c in channels.items()
    ]  # fmt: skip
    return {"head": list(keys), "rows": rows, "data": "held-out data" if grown else "all data"}


def _records(view: View) -> list[tuple[str, str, str, str]]:
    """Name, role, error before and after of each record; nothing when there is only one."""
    if len(view.records) < 2:
        return []
    rows = (
        sorted(view.records, key=lambda r: -_rms(r, r.before))
        if len(view.records) > MOST_RECORDS
        else view.records
    )
    return [
        (r.name, _role(r), newtons(_rms(r, r.before)), newtons(_rms(r, r.after)))
        for r in rows[:MOST_RECORDS]
    ]


def _rms(
    record: RecordView, model: np.ndarray[tuple[int, ...], np.dtype[np.float64]] | None
) -> float:
    """Root mean square error over the scored samples [N]."""
    if model is None or not record.scored.any():
        return float("nan")
    return float(np.sqrt(np.mean((record.measured - model)[record.scored] ** 2)))


def _role(record: RecordView) -> str:
    """What the record was used for."""
    held = record.held_out[record.scored]
    return "held out" if held.all() else "fitted, parts held out" if held.any() else "fitted"
