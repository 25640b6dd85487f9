"""How often `lab fleet` is right where everything is known: `python -m test.fleet_score --fleets 20`."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from er_model_lab.fleets.overview import overview
from er_models.files import write_json
from scipy.stats import t as student

from test.fleet_truth import SPAN, TERMS, Fleet, fleet

TARGETS = {
    "precision": (0.95, 1.0), "recall": (0.95, 1.0), "false_discoveries": (0.0, 0.05),
    "change_points": (0.9, 1.0), "cover": (0.85, 0.95),
}  # fmt: skip
"""What must hold over all fleets, from and to; where a fade begins is less certain than where a step is."""
NEAR = 0.1
"""Share of the span within which a change must be placed."""


@dataclass
class Score:
    """Units rightly and wrongly named and missed, shares of false ones, distances of changes, intervals that hit."""

    right: int = 0
    wrong: int = 0
    missed: int = 0
    shares: list[float] = field(default_factory=list)
    off: list[float] = field(default_factory=list)
    hit: list[bool] = field(default_factory=list)

    def add(self, truth: Fleet) -> None:
        """Count one fleet."""
        found = overview(truth.units, truth.recordings)
        named, ill = {d["unit"] for d in found.content["differ"]}, set(truth.effects)
        self.right += len(named & ill)
        self.wrong += len(named - ill)
        self.missed += len(ill - named)
        self.shares.append(len(named - ill) / max(len(named), 1))
        for unit in named & ill:
            if truth.begins[unit] > 0.0:
                changes = found.units[unit]["changes"]
                self.off.append(
                    abs(changes[0]["at"] - truth.begins[unit]) / SPAN if changes else 1.0
                )
        half = student.ppf(0.95, len(truth.units) - 1)
        for unit in truth.values.keys() - ill:
            for term in TERMS:
                value, sd, _ = found.units[unit]["pooled"][term]
                self.hit.append(abs(value - truth.values[unit][term]) < half * sd)

    def shown(self) -> dict[str, float]:
        """The numbers that `TARGETS` bounds."""
        return {
            "precision": self.right / max(self.right + self.wrong, 1),
            "recall": self.right / max(self.right + self.missed, 1),
            "false_discoveries": float(np.mean(self.shares)),
            "change_points": float(np.mean(np.array(self.off) < NEAR)), "cover": float(np.mean(self.hit)),
        }  # fmt: skip


def score(seeds: Iterable[int], size: float = 1.0) -> Score:
    """The score of a fleet for each seed; size: of the effects [standard deviations of the noise of the force]."""
    total = Score()
    for seed in seeds:
        total.add(fleet(seed, size=size))
    return total


def main() -> None:
    """Print the score."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fleets", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1, help="of the first fleet")
    parser.add_argument(
        "--size", type=float, default=1.0, help="of the effects [sd of the noise of the force]"
    )
    parser.add_argument("--json", type=Path, help="file for the figures")
    asked = parser.parse_args()
    found = score(range(asked.seed, asked.seed + asked.fleets), asked.size)
    print(
        f"{asked.fleets} fleets: {found.right} units rightly named, {found.wrong} wrongly, {found.missed} missed"
    )
    if asked.json is not None:
        counts = {"right": found.right, "wrong": found.wrong, "missed": found.missed}
        write_json(asked.json, {"fleets": asked.fleets, **counts, **found.shown()})
    for name, value in found.shown().items():
        low, high = TARGETS[name]
        print(f"{name:18} {value:.3f}  ({low} to {high})")


if __name__ == "__main__":
    main()
