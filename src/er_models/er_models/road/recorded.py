"""Recorded road: a column of a CSV or Parquet file, or given values; straight in between."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from er_models.errors import InputError
from er_models.spec import Array, Kind, Number, Series, Text
from er_models.table import read_columns


def samples(s: Mapping[str, Any], what: str) -> tuple[Array, Array]:
    """Times from zero on [s] and values, each (n,); `what` names the signal in errors."""
    if bool(s["file"]) == bool(len(s["values"])):
        both = "both" if s["file"] else "neither"
        raise InputError(what, "file", "either 'file' or 'values' with 'dt'", both)
    if s["file"]:
        t, y = read_columns(Path(s["file"]), s["time_column"], s["column"])
        return t - t[0], y
    values = np.asarray(s["values"], float)
    return np.arange(values.size) * s["dt"], values


def place(s: Mapping[str, Any], t: Array, end: float) -> Array:
    """Times within the record for the times t: held at the end, or from the start again."""
    asked = t + float(s["start"])
    return np.asarray(np.mod(asked, end) if s["after"] == "repeat" and end > 0.0 else asked)


def make(s: Mapping[str, Any], t: Array, _seed: int) -> Array:
    """Height [m], (n,)."""
    times, heights = samples(s, "road")
    return np.interp(place(s, t, float(times[-1])), times, heights)


def settings_of(
    column: str, unit: str, low: float, high: float
) -> tuple[Text | Number | Series, ...]:
    """Settings of a recorded signal; column: default name of its column."""
    return (
        Text("file", "", "CSV or Parquet file; in a program file relative to it"),
        Text("column", column, "name of the column"),
        Text("time_column", "t", "name of the column with the time in s"),
        Series("values", unit, (), low, high, "the samples themselves, instead of a file"),
        Number("dt", "s", 0.005, 1e-6, 1e3, "sample time of `values`"),
        Number("start", "s", 0.0, 0.0, 1e6, "where in the record to begin"),
        Text("after", "hold", "what follows the end of the record", ("hold", "repeat")),
    )


KIND = Kind("recorded", "recorded road", settings_of("road", "m", -10.0, 10.0), make)
