"""Gain files of the LPV controller: vertices in SI units, and enough to prove them again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from er_models.errors import InputError
from er_models.files import write_whole
from er_models.linear import fingerprint
from er_models.model import Array, Model
from er_models.yaml_file import read_yaml

from er_ftc_controller.synthesis.certificate import proved
from er_ftc_controller.synthesis.lmi import Solution, Vertex
from er_ftc_controller.synthesis.weights import Plant, Weights, generalised_plant

SCHEMA = "er_lpv_gains 1"


@dataclass(frozen=True, eq=False)
class Loaded:
    """A proved controller: the plant it was made for, its vertices (scaled as the plant), hash of the content."""

    plant: Plant
    solution: Solution
    digest: str


def save_gains(
    path: str | Path, model: Model, plant: Plant, solution: Solution, notes: Mapping[str, Any]
) -> None:
    """Write a gain file, whole or not at all. The state of the controller has no unit; y is in m, u_er in N."""
    rate, road = plant.rate, plant.weights.road
    vertices = [
        {
            "rho": k.rho, "gamma": k.gamma,
            "A": _flat(k.A * rate), "B": _flat(k.B * rate / road), "C": _flat(k.C * plant.unit),
        }
        for k in solution.vertices
    ]  # fmt: skip
    content: dict[str, Any] = {
        "schema": SCHEMA,
        "controller": "lpv_ftc",
        "model": {"name": model.name, "fingerprint": fingerprint(model)},
        "weights": {
            key: list(v) if isinstance(v, tuple) else v for key, v in asdict(plant.weights).items()
        },
        "vertices": vertices,
        "P": _flat(solution.P),
        "optimum": solution.optimum,
        "status": solution.status,
        **notes,
    }
    content["digest"] = _digest(content)
    text = yaml.safe_dump(content, sort_keys=False, width=99, default_flow_style=None)
    write_whole(Path(path), text)


def load_gains(path: str | Path, model: Model) -> Loaded:
    """Read a gain file for this model and prove its inequalities again, exactly.

    Raises `InputError` in one line: no file, another kind, edited by hand, another model, or no proof.
    """
    path = Path(path)
    content = read_yaml(path, "a gain file")
    again = f"make it again: er synth lpv_ftc --model MODEL --out {path}"
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise InputError(path, "schema", f"'{SCHEMA}'", "another kind of file")
    if content.get("digest") != _digest(content):
        raise InputError(path, "digest", f"the file as it was written ({again})", "an edited file")
    own, found = fingerprint(model), content["model"]["fingerprint"]
    if own != found:
        expected = f"{own} of model '{model.name}' ({again})"
        raise InputError(path, "model.fingerprint", expected, found)
    entries = content["weights"]
    known: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in entries.items()}
    weights = Weights(**known)
    plant = generalised_plant(model, weights)
    rate, road = plant.rate, weights.road
    vertices = tuple(
        Vertex(
            v["rho"], _matrix(v["A"]) / rate, _matrix(v["B"]) * road / rate,
            _matrix(v["C"]) / plant.unit, v["gamma"],
        )
        for v in content["vertices"]
    )  # fmt: skip
    solution = Solution(vertices, _matrix(content["P"]), content["optimum"], content["status"])
    _, failed = proved(plant, solution)
    if failed:
        raise InputError(path, "vertices", f"inequalities that hold ({again})", failed)
    return Loaded(plant, solution, content["digest"])


def _flat(matrix: Array) -> dict[str, list[Any]]:
    """Shape and entries row by row."""
    return {"shape": list(matrix.shape), "data": [float(v) for v in np.ravel(matrix)]}


def _matrix(entry: Mapping[str, Any]) -> Array:
    """The matrix again."""
    return np.array(entry["data"], float).reshape(entry["shape"])


def _digest(content: Mapping[str, Any]) -> str:
    """Hash of everything but the digest itself."""
    rest = {key: value for key, value in content.items() if key != "digest"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()[:16]
