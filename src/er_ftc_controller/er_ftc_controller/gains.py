"""Gain files of the LPV controller: vertices in SI units, and enough to prove them again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from er_models.constants import SAMPLE_TIME
from er_models.errors import InputError
from er_models.files import write_whole
from er_models.gain_file import Document, digest, flat, read
from er_models.linear import fingerprint
from er_models.model import Model

from er_ftc_controller.synthesis.certificate import proved
from er_ftc_controller.synthesis.solution import Solution, Vertex
from er_ftc_controller.synthesis.state_lqr import REGIMES
from er_ftc_controller.synthesis.state_proof import Feedback, StateProof, failed, law_of, loops_of
from er_ftc_controller.synthesis.weights import Plant, Weights, generalised_plant

SCHEMA = "er_lpv_gains 1"


@dataclass(frozen=True, eq=False)
class Loaded:
    """A proved controller: the plant it was made for, its vertices (scaled as the plant), hash of the content.

    feedback: the state feedback, None in a file without one.
    """

    plant: Plant
    solution: Solution
    digest: str
    feedback: Feedback | None = None


def save_gains(
    path: str | Path, model: Model, plant: Plant, solution: Solution, notes: Mapping[str, Any],
    feedback: Feedback | None = None,
) -> None:  # fmt: skip
    """Write a gain file, whole or not at all. The state of the controller has no unit; y is in m, u_er in N."""
    rate, road = plant.rate, plant.weights.road
    vertices = [
        {
            "rho": k.rho, "gamma": k.gamma,
            "A": flat(k.A * rate), "B": flat(k.B * rate / road), "C": flat(k.C * plant.unit),
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
        "P": flat(solution.P),
        "P_sampled": flat(solution.P_sampled),
        "optimum": solution.optimum,
        "status": solution.status,
        **notes,
    }
    if feedback is not None:
        content["state_feedback"] = _section(feedback)
    content["digest"] = digest(content)
    text = yaml.safe_dump(content, sort_keys=False, width=99, default_flow_style=None)
    write_whole(Path(path), text)


def load_gains(path: str | Path, model: Model) -> Loaded:
    """Read a gain file for this model and prove its inequalities again, exactly, those of the sampled loop too.

    path: of the file, or the name of shipped gains (`lpv_ftc`).

    Raises `InputError` in one line: no file, another kind, edited by hand, another model, or no proof.
    """
    file = read(path)
    path, content = file.path, file.content
    again = f"make it again: er synth lpv_ftc --model MODEL --out {path}"
    if content.get("schema") != SCHEMA:
        raise InputError(path, "schema", f"'{SCHEMA}'", "another kind of file")
    if content.get("digest") != digest(content):
        raise InputError(path, "digest", f"the file as it was written ({again})", "an edited file")
    own, found = fingerprint(model), file.at("model.fingerprint")
    if own != found:
        expected = f"{own} of model '{model.name}' ({again})"
        raise InputError(path, "model.fingerprint", expected, found)
    entries = file.at("weights")
    known: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in entries.items()}
    weights = Weights(**known)
    plant = generalised_plant(model, weights)
    vertices = tuple(_vertex(Document(path, entry), plant) for entry in file.at("vertices"))
    P, sampled = (file.matrix(key, (None, None)) for key in ("P", "P_sampled"))
    solution = Solution(vertices, P, sampled, file.number("optimum"), str(file.at("status")))
    _, failed = proved(plant, solution)
    if failed:
        raise InputError(path, "vertices", f"inequalities that hold ({again})", failed)
    feedback = _feedback(file, model, again) if "state_feedback" in content else None
    return Loaded(plant, solution, content["digest"], feedback)


def _section(feedback: Feedback) -> dict[str, Any]:
    """The state feedback [SI] and its proof, scaled as `state_proof.loops_of`."""
    law, proof = feedback
    return {
        "corner": law.corner, "K": flat(np.array(law.gains)), "gammas": list(proof.gammas),
        "P": flat(proof.P), "P_sampled": flat(proof.P_sampled),
    }  # fmt: skip


def _feedback(file: Document, model: Model, again: str) -> Feedback:
    """The state feedback of a file, proved again; `InputError` where it is not."""
    at, many = "state_feedback", len(REGIMES)
    gains, corner = file.matrix(f"{at}.K", (many, 5)), file.number(f"{at}.corner")
    P, sampled = (file.matrix(f"{at}.{key}", (6, 6)) for key in ("P", "P_sampled"))
    gammas = file.numbers(f"{at}.gammas", 1 + many)
    proof = StateProof(P, sampled, tuple(gammas.tolist()))
    if why := failed(loops_of(model, list(gains), corner), proof, SAMPLE_TIME):
        raise InputError(file.path, at, f"inequalities that hold ({again})", why)
    return Feedback(law_of(model, gains, corner), proof)


def _vertex(entry: Document, plant: Plant) -> Vertex:
    """A controller at one rho, scaled as the plant again."""
    rate, road, n = plant.rate, plant.weights.road, plant.A.shape[0]
    return Vertex(
        entry.number("rho"), entry.matrix("A", (n, n)) / rate, entry.matrix("B", (n, 1)) * road / rate,
        entry.matrix("C", (1, n)) / plant.unit, entry.number("gamma"),
    )  # fmt: skip
