"""Gain files of the body controller: weights, gain, and what it takes to check them again."""

from __future__ import annotations

from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from er_models.car.body import Car
from er_models.car.linear import linear_car
from er_models.errors import InputError
from er_models.files import write_whole
from er_models.gain_file import digest, flat, read
from er_models.model import Array
from er_models.spec import REQUIRED, Number, settings
from er_models.yaml_file import read_yaml

from er_ftc_controller.body_weights import FORGET, BodyWeights

SCHEMA = "er_body_gain 1"
_WEIGHTS = tuple(
    Number(f.name, "SI", REQUIRED, 1e-9, 1e9, "a size that counts as one")
    for f in fields(BodyWeights)
)


def load_weights(path: str | Path) -> BodyWeights:
    """Weights from a file of their names; `InputError` naming file, key, expected and found."""
    found = read_yaml(Path(path), "a file of weights")
    if not isinstance(found, dict):
        raise InputError(path, "", "a mapping of names to values", type(found).__name__)
    return BodyWeights(**settings(_WEIGHTS, found, path, also=()))


def save_body_gain(path: str | Path, car: Car, weights: BodyWeights, gain: Array) -> None:
    """Write a gain file, whole or not at all; gain (4, 15)."""
    content: dict[str, Any] = {
        "schema": SCHEMA, "controller": "body_lqr", "car": {"name": car.name, "fingerprint": fingerprint(car)},
        "weights": asdict(weights), "K": flat(gain), "slowest_pole": float(f"{slowest(car, gain):.6g}"),
    }  # fmt: skip
    content["digest"] = digest(content)
    write_whole(
        Path(path), yaml.safe_dump(content, sort_keys=False, width=99, default_flow_style=None)
    )


def load_body_gain(path: str | Path, car: Car) -> tuple[Array, str]:
    """Gain (4, 15) for this car, and the digest of its file; the closed loop without limits is checked again.

    Raises `InputError` in one line: no file, another kind, edited by hand, another car, or an unstable loop.
    """
    file = read(path)
    again = f"make it again: er synth body_lqr --car CAR --weights WEIGHTS --out {file.path}"
    if file.content.get("schema") != SCHEMA:
        raise InputError(file.path, "schema", f"'{SCHEMA}'", "another kind of file")
    if file.content.get("digest") != digest(file.content):
        raise InputError(
            file.path, "digest", f"the file as it was written ({again})", "an edited file"
        )
    own, found = fingerprint(car), file.at("car.fingerprint")
    if own != found:
        raise InputError(
            file.path, "car.fingerprint", f"{own} of car '{car.name}' ({again})", found
        )
    gain = file.matrix("K", (4, 15))
    if slowest(car, gain) >= 0.0:
        raise InputError(
            file.path, "K", f"a stable loop ({again})", f"a pole at {slowest(car, gain):g} 1/s"
        )
    return gain, str(file.content["digest"])


def slowest(car: Car, gain: Array) -> float:
    """Largest real part of the poles of the car under its gain without limits [1/s]."""
    form = linear_car(car)
    a = form.A - FORGET * np.diag(np.repeat([0.0, 0.0, 1.0, 0.0], [4, 3, 4, 4]))
    return float(np.linalg.eigvals(a - form.B @ gain).real.max())


def fingerprint(car: Car) -> str:
    """Hash of the car's linear form, on six digits."""
    form = linear_car(car)
    rounded = [float(f"{v:.6g}") + 0.0 for v in np.concatenate([form.A.ravel(), form.B.ravel()])]
    return digest({"form": rounded})
