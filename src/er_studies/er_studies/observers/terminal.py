"""The comparison on a terminal: the thesis's tables with ours and the peers', then every scenario."""

from __future__ import annotations

import math
from collections.abc import Sequence

from er_observers.programs import OBSERVERS
from rich.table import Table

from er_studies.observers.run import Outcome
from er_studies.observers.scenarios.scenario import Scenario
from er_studies.observers.table import (
    NEAR,
    Row,
    ratio_to_peers,
    rows_of,
    summaries,
)

THESIS = {name: OBSERVERS[name].title for name in ("nlpv_polytopic", "nlpv_gridding", "unified")}


def tables(
    scenarios: Sequence[Scenario], outcomes: Sequence[Outcome], titles: dict[str, str],
    ours: Sequence[str],
) -> list[Table]:  # fmt: skip
    """All tables, in the order they are read."""
    rows = rows_of(scenarios, outcomes)
    shown = [_thesis(rows, titles)] if any(r.window.table for r in rows) else []
    early = [r for r in rows if r.alone and (r.window.table or r.window.begin == 0.0)]
    return [
        *shown,
        *([_alone(early, titles)] if early else []),
        _errors(rows, titles, ours),
        _settling(scenarios, outcomes, titles),
    ]


def _thesis(rows: Sequence[Row], titles: dict[str, str]) -> Table:
    """The thesis's figures beside those of everything that ran."""
    table = _table(
        "NRMSE [%], median over the roads; an observer below its own thesis figure is marked *",
        ("thesis", "scenario", "time", "roads"),
        (*(f"thesis: {t}" for t in THESIS.values()), *titles.values()),
    )
    for r in rows:
        if r.window.table:
            published = [_percent(r.window.published.get(n)) for n in THESIS]
            found = [_beside(r, n, r.errors) for n in titles]
            table.add_row(r.window.table, r.scenario.name, r.window.name, str(r.roads), *published, *found)  # fmt: skip
    return table


def _alone(rows: Sequence[Row], titles: dict[str, str]) -> Table:
    """The proved gains without the filter that all observers begin with."""
    names = [n for n in titles if any(n in r.alone for r in rows)]
    table = _table(
        "NRMSE [%] without start phase: the proved gains alone, median over the roads; * below its own thesis figure",
        ("thesis", "scenario", "start", "time", "roads"),
        (*(f"thesis: {t}" for t in THESIS.values()), *(titles[n] for n in names)),
    )
    for r in rows:
        words = (r.window.table, r.scenario.name, r.scenario.start, r.window.name, str(r.roads))
        published = (_percent(r.window.published.get(n)) for n in THESIS)
        table.add_row(*words, *published, *(_beside(r, n, r.alone) for n in names))
    return table


def _beside(row: Row, name: str, errors: dict[str, float]) -> str:
    """An error, marked where it is below the thesis's own figure."""
    return _percent(errors[name]) + ("*" if errors[name] < row.window.published.get(name, 0.0) else "")  # fmt: skip


def _errors(rows: Sequence[Row], titles: dict[str, str], ours: Sequence[str]) -> Table:
    """Every window; how the worst of our observers stands to the better peer."""
    peers = [n for n in titles if n not in ours]
    table = _table(
        f"NRMSE [%], median over the roads; ! where one of ours is beyond {NEAR} of the better peer; "
        "belief: what is believed wrongly leaves this of a known motion",
        ("scenario", "start", "time", "roads"),
        (*titles.values(), "belief", "ours / better peer"),
    )
    for r in rows:
        ratio = max((ratio_to_peers(r, n, peers) for n in ours), default=math.nan)
        mark = f"{ratio:.2f}" + (" !" if ratio > NEAR else "")
        errors = (_percent(r.errors[n]) for n in titles)
        floor = "-" if math.isnan(r.floor) else _percent(r.floor)
        words = (r.scenario.name, r.scenario.start, r.window.name, str(r.roads))
        table.add_row(*words, *errors, floor, mark)
    return table


def _settling(
    scenarios: Sequence[Scenario], outcomes: Sequence[Outcome], titles: dict[str, str]
) -> Table:
    """When the error stays below 2 %, and how much of what is wrong is called OK."""
    by = summaries(outcomes)
    table = _table(
        "seconds until the error stays below 2 % | share of samples wrong by more and called OK [%]",
        ("scenario",),
        tuple(titles.values()),
    )
    for s in scenarios:
        cells = []
        for n in titles:
            one = by[s.name, n]
            settled = "never" if math.isinf(one.settled) else f"{one.settled:.2f}"
            cells.append(f"{settled} | {100 * one.unnoticed:.1f}")
        table.add_row(s.name, *cells)
    return table


def _table(title: str, words: Sequence[str], numbers: Sequence[str]) -> Table:
    """An empty table."""
    table = Table(title=title, title_justify="left")
    for name in words:
        table.add_column(name, overflow="fold")
    for name in numbers:
        table.add_column(name, justify="right", overflow="fold")
    return table


def _percent(value: float | None) -> str:
    """Two decimals of a per cent."""
    return "-" if value is None else f"{100 * value:.2f}"
