"""Peers tuned: random search with the same budget for all, on roads that are not scored."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
import yaml
from er_models.files import load_model, write_whole
from er_models.model import Array, Model

from er_studies.observers.classes import TUNING, scenario, with_noise
from er_studies.observers.nrmse import nrmse
from er_studies.observers.peers.known import PEERS, peer
from er_studies.observers.run import follow
from er_studies.observers.scenarios.drive import drive
from er_studies.programs import program_of, run

DRIVES = (("A", "healthy", 20), ("C", "healthy", 20), ("E", "healthy", 20), ("B", "f1", 100))
"""Class, case and noise of the deflection [um] of the drives."""
SECONDS = 5.0


def score(
    name: str, model: Model, values: Mapping[str, float], records: Sequence[dict[str, Array]]
) -> float:
    """Geometric mean of the errors from 2 s on; infinite where the peer fails."""
    try:
        made = peer(name, model, values)
        errors = []
        for record in records:
            rows = record["t"] >= 2.0
            force = follow(made, record, None).force
            errors.append(nrmse(record["damper_force"][rows], force[rows]))
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        return math.inf
    found = float(np.mean(np.log(errors)))
    return found if math.isfinite(found) else math.inf


def tuned(
    name: str, model: Model, budget: int, records: Sequence[dict[str, Array]]
) -> dict[str, float]:
    """The best of a budget of trials: half drawn over the whole range, half about the best so far."""
    bounds = PEERS[name].tuned
    low, high = (np.log([b[k] for b in bounds.values()]) for k in (0, 1))
    random = np.random.default_rng([TUNING, len(bounds)])
    best, least = 0.5 * (low + high), math.inf
    for k in range(budget if bounds else 0):
        near = best + random.normal(size=len(low)) * (high - low) * 0.3 * (1.0 - k / budget)
        trial = random.uniform(low, high) if k < budget // 2 else near.clip(low, high)
        found = score(name, model, dict(zip(bounds, np.exp(trial).tolist(), strict=True)), records)
        if found < least:
            best, least = trial, found
    return {q: float(f"{v:.4g}") for q, v in zip(bounds, np.exp(best), strict=True)}


def main(
    out: Annotated[Path, typer.Option(help="File to write.")] = Path("config/peers.yaml"),
    config: Annotated[Path, typer.Option(help="Folder with vehicles.")] = Path("config"),
    budget: Annotated[int, typer.Option(min=1, help="Trials of each peer.")] = 40,
) -> None:
    """Tune every peer with the same number of trials."""
    car = load_model(config / "vehicles" / "inove_quarter_car.yaml")
    records = [
        drive(with_noise(scenario(c, case, TUNING + k, SECONDS), noise), car)
        for k, (c, case, noise) in enumerate(DRIVES)
    ]
    found = {name: tuned(name, car, budget, records) for name in PEERS}
    text = yaml.safe_dump({"budget": budget, "peers": found}, sort_keys=False)
    write_whole(out, f"# Made by ./er study tune_peers --budget {budget}\n{text}")


app = program_of(main)

if __name__ == "__main__":
    run(app)
