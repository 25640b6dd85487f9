"""Files of a case: records as CSV, the start model as YAML, and the sealed truth."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from pyarrow import csv

from test.rough.device import BETA, C0, C1, FC, FY, K0, K1, TAU, UM, V0, Array
from test.rough.rig import DRIVEN, Rig

ORDER = (
    "t", "deflection", "deflection_velocity", "duty", "damper_force", "sprung_acceleration", "unsprung_acceleration",
)  # fmt: skip
Values = dict[str, dict[str, tuple[float, str]]]


def write_record(path: Path, columns: dict[str, Array]) -> None:
    """One record, its columns in the usual order, eight digits each; of the time six decimals."""
    rounded = {}
    for name in ORDER:
        if name in columns:
            y = columns[name]
            size = (
                10.0 ** (8 - np.ceil(np.log10(np.abs(y).max() + 1e-300))) if name != "t" else 1e6
            )
            rounded[name] = np.round(y * size) / size
    path.parent.mkdir(parents=True, exist_ok=True)
    csv.write_csv(pa.table(rounded), path, csv.WriteOptions(quoting_style="none"))


def start_values(rig: Rig, rng: np.random.Generator, off: float = 0.12) -> Values:
    """The start model: the base of the device, each value some per cent off; value and unit by effect and parameter."""
    b = rig.base * (1.0 + rng.uniform(-off, off, rig.base.size))
    b[UM] = rig.base[UM]
    out: Values = {"passive": {"k0": (b[K0], "N/m"), "c0": (b[C0], "N s/m")}}
    if rig.device == "mr":
        sigma = float(b[FY] * b[UM] ** (1.0 - b[BETA]))
        out["bingham_yield"] = {
            "sigma": (sigma, "N"),
            "beta": (b[BETA], "1"),
            "v_0": (1.0 / rig.base[C1], "m/s"),
        }
    elif rig.device in DRIVEN:
        out["guo_yield"] = {"f_c": (b[FY], "N/duty"), "k1": (b[K1], "1/m"), "c1": (b[C1], "s/m")}
    if rig.device in DRIVEN:
        out["response"] = {"tau": (b[TAU], "s")}
    if rig.device == "brake":
        out["coulomb_friction"] = {"F_c": (b[FC], "N"), "v_0": (b[V0], "m/s")}
    return out


def write_model(path: Path, rig: Rig, values: Values) -> None:
    """The start model with its envelope."""
    size = {
        "force": rig.force,
        "deflection": rig.stroke,
        "velocity": rig.velocity,
        "duty": rig.duty,
    }
    lines = [
        "schema: er_model 1",
        f"name: {rig.device}",
        "envelope:",
        *(f"  {k}: {float(v)!r}" for k, v in size.items()),
    ]
    lines.append("effects:")
    for effect, entries in values.items():
        lines.append(f"  {effect}:")
        lines += [
            f'    {k}: {{value: {float(v)!r}, unit: "{unit}"}}' for k, (v, unit) in entries.items()
        ]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_truth(path: Path, truth: dict[str, Any]) -> None:
    """What was hidden, which whatever is judged must not read."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(truth, indent=2) + "\n", encoding="utf-8")
