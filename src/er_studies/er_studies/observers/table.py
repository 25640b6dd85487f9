"""What the comparison found, as rows: per scenario and window the median over the roads."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.special import bdtr

from er_studies.observers.run import Outcome
from er_studies.observers.scenarios.scenario import Scenario, Window

NEAR = 1.1
"""An observer keeps up with the peers where its error is within this factor of the better one's."""


class Row(NamedTuple):
    """A window of a scenario: its thesis figures and the median NRMSE of each estimator; roads in it.

    each: NRMSE of every estimator road by road; floor: median of `Outcome.floors`, NaN where nothing is wrong;
    alone: as errors, of the proved gains without start phase.
    """

    scenario: Scenario
    window: Window
    errors: dict[str, float]
    worst: dict[str, float]
    roads: int
    each: dict[str, list[float]]
    floor: float
    alone: dict[str, float]


class Summary(NamedTuple):
    """An estimator over all roads of a scenario: medians of settling time [s] and share unnoticed."""

    settled: float
    unnoticed: float


def rows_of(scenarios: Iterable[Scenario], outcomes: Sequence[Outcome]) -> list[Row]:
    """One row per window of each scenario."""
    rows = []
    for s in scenarios:
        mine = [o for o in outcomes if o.scenario == s.name]
        names = list(dict.fromkeys(o.estimator for o in mine))
        for k, window in enumerate(s.windows):
            each = {n: [o.errors[k] for o in mine if o.estimator == n] for n in names}
            medians = {n: float(np.median(v)) for n, v in each.items()}
            worst = {n: float(np.max(v)) for n, v in each.items()}
            floors = [o.floors[k] for o in mine if o.floors]
            floor = float(np.median(floors)) if floors else float("nan")
            alone = {n: [o.alone[k] for o in mine if o.estimator == n and o.alone] for n in names}
            bare = {n: float(np.median(v)) for n, v in alone.items() if v}
            roads = len(mine) // max(1, len(names))
            rows.append(Row(s, window, medians, worst, roads, each, floor, bare))
    return rows


def summaries(outcomes: Sequence[Outcome]) -> dict[tuple[str, str], Summary]:
    """By scenario and estimator."""
    keys = dict.fromkeys((o.scenario, o.estimator) for o in outcomes)
    return {
        key: Summary(*(
            float(np.median([getattr(o, field) for o in outcomes if (o.scenario, o.estimator) == key]))
            for field in Summary._fields
        ))
        for key in keys
    }  # fmt: skip


def ratio_to_peers(row: Row, name: str, peers: Sequence[str]) -> float:
    """Error of an observer over that of the better peer."""
    return row.errors[name] / min(row.errors[p] for p in peers)


def paired(row: Row, ours: Sequence[str]) -> tuple[float, float, float] | None:
    """Error of the best of ours less that of the best peer, road by road: median and its 95 % interval.

    The interval lies between order statistics and asks for no distribution (Conover 1999, 3.2); None where
    there are too few roads for one.
    """
    names = (ours, [n for n in row.each if n not in ours])
    if not all(names):
        return None
    mine, peer = (min(group, key=lambda n: row.errors[n]) for group in names)
    less = np.sort(np.subtract(row.each[mine], row.each[peer]))
    skip = int(np.searchsorted(bdtr(np.arange(less.size + 1), less.size, 0.5), 0.025))
    if skip < 1:
        return None
    return float(np.median(less)), float(less[skip - 1]), float(less[less.size - skip])


def document(
    scenarios: Sequence[Scenario],
    outcomes: Sequence[Outcome],
    titles: dict[str, str],
    ours: Sequence[str],
) -> dict[str, Any]:
    """Everything as plain values for a JSON file; settling `null` means never."""
    by = summaries(outcomes)
    return {
        "estimators": titles,
        "windows": [
            {
                "scenario": r.scenario.name, "title": r.scenario.title, "start": r.scenario.start,
                "begin": r.window.begin, "end": r.window.end, "table": r.window.table,
                "roads": r.roads, "published": dict(r.window.published),
                "nrmse": r.errors, "nrmse_worst": r.worst,
                "nrmse_without_start_phase": r.alone, "floor": _plain(r.floor),
                "best_of_ours_less_best_peer": paired(r, ours),
                "settled": {n: _plain(by[r.scenario.name, n].settled) for n in r.errors},
                "unnoticed": {n: by[r.scenario.name, n].unnoticed for n in r.errors},
            }
            for r in rows_of(scenarios, outcomes)
        ],
    }  # fmt: skip


def _plain(value: float) -> float | None:
    """A number that JSON knows."""
    return value if np.isfinite(value) else None


def csv_lines(scenarios: Sequence[Scenario], outcomes: Sequence[Outcome]) -> list[str]:
    """One line per road, window and estimator."""
    lines = ["scenario,road,begin,end,estimator,nrmse,settled,unnoticed"]
    windows = {s.name: s.windows for s in scenarios}
    for o in outcomes:
        for window, error in zip(windows[o.scenario], o.errors, strict=True):
            lines.append(
                f"{o.scenario},{o.number},{window.begin:g},{window.end:g},{o.estimator},"
                f"{error:.6g},{o.settled:.6g},{o.unnoticed:.6g}"
            )
    return lines
