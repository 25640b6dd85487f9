"""Deflection against comfort of the LPV law by the deflection alone: what horizon, dead zone and mu cost and bring."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array

from er_studies.control.closed_loop import known
from er_studies.control.rivals import Law
from er_studies.control.run import Setup, judged, run
from er_studies.control.scenarios import Scenario

POINTS: Sequence[Mapping[str, Any]] = tuple(
    {"horizon": horizon, "dead_zone": zone, "mu": mu}
    for horizon, zone, mu in ((0.01, 0.05, 0.2), (0.01, 0.2, 0.2), (0.02, 0.05, 0.2), (0.02, 0.12, 0.2),
                              (0.02, 0.2, 0.2), (0.03, 0.1, 0.2), (0.02, 0.12, 0.8), (0.02, 0.12, 1.6),
                              (0.02, 0.12, 4.0), (0.02, 0.12, math.inf), (0.02, 0.2, 1.6), (0.02, 0.05, 4.0))
)  # fmt: skip
"""Changes of the shipped parameters; an infinite mu keeps rho at its lowest."""


class Point(NamedTuple):
    """Shares of the passive car's rms deflection and comfort by which ours differ, mean over roads; by fault.

    gained: share of the nominal controller's rms deflection by which ours is lower. moved: share of the samples at
    which rho is above its lowest.
    """

    changes: Mapping[str, Any]
    deflection: Mapping[str, float]
    comfort: Mapping[str, float]
    gained: Mapping[str, float]
    moved: Mapping[str, float]


def points(
    setup: Setup, scenario: Scenario, faults: Sequence[str], seeds: int,
    changes: Sequence[Mapping[str, Any]] = POINTS, tick: Callable[[int, int], None] | None = None,
) -> list[Point]:  # fmt: skip
    """Every point on the first roads of a scenario, the faults known."""
    passive = {f: _felt(setup, scenario, f, setup.law("passive", scenario), seeds) for f in faults}
    found = []
    for done, change in enumerate(changes, 1):
        p = replace(
            setup.parameters, feedback="deflection", u_max=scenario.duty_max, latency=scenario.latency * DT, **change,
        )  # fmt: skip
        ours, nominal = (
            {f: _felt(setup, scenario, f, law, seeds) for f in faults}
            for law in (setup.built(p), setup.built(p, nominal=True))
        )
        share = {f: np.mean(ours[f][:, :2] / passive[f][:, :2], axis=0) - 1.0 for f in faults}
        found.append(Point(
            change, {f: float(share[f][0]) for f in faults}, {f: float(share[f][1]) for f in faults},
            {f: 1.0 - float(np.mean(ours[f][:, 0] / nominal[f][:, 0])) for f in faults},
            {f: float(np.mean(ours[f][:, 2])) for f in faults},
        ))  # fmt: skip
        if tick is not None:
            tick(done, len(changes))
    return found


def markdown(found: Sequence[Point]) -> str:
    """The points as a table."""
    faults = list(found[0].comfort)
    heads = [f"{f}: deflection, comfort" for f in faults] + [
        f"{f}: less deflection than nominal" for f in faults if f != "healthy"
    ]
    heads.append(f"rho above its lowest: {', '.join(faults)}")
    lines = [
        "| horizon [ms] | dead zone | mu [N] | " + " | ".join(heads) + " |",
        "|---" * (len(heads) + 3) + "|",
    ]
    for p in found:
        cells = [f"{100 * p.deflection[f]:+.1f} %, {100 * p.comfort[f]:+.1f} %" for f in faults]
        cells += [f"{100 * p.gained[f]:.1f} %" for f in faults if f != "healthy"]
        cells.append(", ".join(f"{100 * p.moved[f]:.1f} %" for f in faults))
        first = f"| {1e3 * p.changes['horizon']:g} | {p.changes['dead_zone']:g} | {p.changes.get('mu', 'shipped')} | "
        lines.append(first + " | ".join(cells) + " |")
    return "\n".join(lines)


def _felt(setup: Setup, scenario: Scenario, fault: str, law: Law, seeds: int) -> Array:
    """Rms deflection [m], comfort [m/s2] and share of samples with rho above its lowest, of each road, (seeds, 3)."""
    rows = []
    for number in range(seeds):
        record = run(setup, scenario, fault, law, known, number)
        m, judging = judged(setup, scenario, record), record["t"] >= scenario.window[0]
        rho = record["rho"][judging]
        rows.append((m.rms, m.comfort, float(np.mean(rho > rho.min()))))
    return np.array(rows)
