"""A fleet: the strangest units, a table of all, effects over units, parameters, what changes, what to record next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np

from er_model_lab.output.report.embed import compact
from er_model_lab.output.report.figure import (
    Axis,
    Figure,
    Level,
    Line,
    Mark,
    Panel,
    Points,
    Scale,
    Tiles,
)
from er_model_lab.output.report.palette import AFTER, BEFORE, ERROR, FLOOR, MUTED
from er_model_lab.output.report.rows import CHUNK, names
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.fleet import change, suggested
from er_model_lab.output.text.units import engineering, parameter, percent, quantity, short
from er_model_lab.view import FleetView, SeriesView, View

STRANGEST, MOST_UNITS, MOST_EFFECTS, MOST_PARAMETERS, MOST_NEXT = 10, 40, 14, 8, 30
PAGE = 50
"""Rows of the table that are seen at once."""
KM, DAY, LAST = 1e3, 86400.0, 253402300799.0
"""Metres, seconds, and the last second that a date can say."""
RECORDINGS = "recordings"
SHOWN = {
    "unit": "unit", "path": "path", "record": "record", "status": "status", "mileage": "mileage [km]", "time": "time",
    "seconds": "length [s]", "rmse": "rmse [N]", "rmse_refitted": "refitted [N]", "damper": "damper", "error": "error",
}  # fmt: skip
"""Columns of the Parquet table that a row of recordings shows, each with its heading."""


def _of(view: View) -> FleetView:
    """The fleet of a view that has one."""
    assert view.fleet is not None
    return view.fleet


def section(view: View) -> Section:
    """How many there are, and the ten strangest with their reports."""
    found, fleet = view.result, _of(view)
    rows = [
        {
            "unit": d["unit"], "page": fleet.pages.get(d["unit"], ""), "p": short(d["p"], 2),
            "in": ", ".join(d["in"][:4]),
            "changes": "; ".join(change(c) for c in d["changes"][:2]),
        }
        for d in found["differ"][:STRANGEST]
    ]  # fmt: skip
    counts = [
        ("units", found["verdicts"]), ("recordings", found["statuses"]),
        ("effects", {e["effect"]: f"{e['units']} ({percent(e['share'])})" for e in found["effects"]}),
    ]  # fmt: skip
    return Section(
        "fleet", "Units that differ",
        facts={"rows": rows, "counts": counts, "failed": found["failed"], "more": len(found["differ"]) - len(rows)},
    )  # fmt: skip


def units(view: View) -> Section:
    """All units in pages, the strangest first."""
    fleet = _of(view)
    head = (
        "unit",
        "verdict",
        "effects",
        "rmse [N]",
        "noise [N]",
        "p",
        "differs in",
        "record next",
    )
    rows = [
        [
            str(r["unit"]), str(r["verdict"]), ", ".join(r.get("effects") or ()), short(r.get("rmse")),
            short(r.get("noise_floor")), short(r["p"], 2), ", ".join(r["differs_in"]),
            "; ".join(map(suggested, r["next"][:1])),
        ]
        for r in fleet.rows
    ]  # fmt: skip
    left = fleet.total - len(rows)
    more = f"{left} more units stand in the Parquet table." if left else ""
    return _paged("units", "Units", head, len(rows), more, rows=rows)


def recordings(view: View) -> Section | None:
    """All recordings in pages, by unit; their rows lie in files beside the page."""
    if "recordings" not in view.result["tables"]:
        return None
    count = view.result["recordings"]
    head = tuple(SHOWN.values())
    return _paged(RECORDINGS, "Recordings", head, count, "", files=names(RECORDINGS, count))


def recording_row(row: Mapping[str, Any]) -> list[str]:
    """Cells of a recording below the headings of `SHOWN`; row: these columns of the Parquet table."""
    far, time, seconds = row["mileage"], row["time"], row["seconds"]
    return [
        row["unit"], row["path"], row["record"], row["status"], "" if far is None else short(far / KM), _date(time),
        short(seconds), short(row["rmse"]), short(row["rmse_refitted"]),
        str(row["damper"] or ""), row["error"] or "",
    ]  # fmt: skip


def _date(time: float | None) -> str:
    """A time [s] as a date where its clock counts from 1970, as seconds else."""
    if time is None:
        return ""
    if not DAY < time < LAST:
        return f"{time:g} s"
    return datetime.fromtimestamp(time, UTC).strftime("%Y-%m-%d %H:%M:%S")


def _paged(
    key: str, title: str, head: Sequence[str], count: int, note: str, **rows: Sequence[Any]
) -> Section:
    """A table that is turned in pages; rows: its `rows`, or the `files` that hold `CHUNK` of them each."""
    told = {"head": head, "size": PAGE, "chunk": CHUNK if "files" in rows else max(count, 1),
            "count": count, **rows}  # fmt: skip
    table = compact(told).replace("<", "\\u003c")
    return Section(key, title, facts={"table": table, "note": note}, template="paged")


def effects(view: View) -> Section | None:
    """A map: how much of the error each effect takes away, unit by unit."""
    rows = [r for r in _of(view).rows if r.get("candidates")][:MOST_UNITS]
    total: dict[str, float] = {}
    for row in rows:
        for effect, (size, *_) in row["candidates"].items():
            total[effect] = max(total.get(effect, 0.0), size or 0.0)
    names = sorted(total, key=lambda e: -total[e])[:MOST_EFFECTS]
    if not names or len(rows) < 2:
        return None
    z = np.array(
        [[(r["candidates"].get(e) or [np.nan])[0] or 0.0 for e in names] for r in rows][::-1],
        float,
    )
    tiles = Tiles(np.arange(len(names) + 1.0), np.arange(len(rows) + 1.0), z)
    x = Axis(ticks=tuple((k + 0.5, e.replace("_", " ")) for k, e in enumerate(names)))
    y = Axis(ticks=tuple((len(rows) - k - 0.5, str(r["unit"])[:14]) for k, r in enumerate(rows)))
    peak = float(np.nanmax(z)) or 1.0
    alt = f"Effect size of {len(names)} effects in {len(rows)} units; the strangest unit is above."
    scale = Scale("effect size [N]", 0.0, peak, ERROR)
    map_ = Figure(
        "fleet_map", alt, (Panel((tiles,), x, y),), height=170 + 16 * len(rows), scale=scale
    )
    return Section(
        "effects", "Units over effects", (map_,), {"caption": alt}, template="fleet_figure"
    )


def parameters(view: View) -> Section | None:
    """How every parameter is distributed: each unit by its own data, and partially pooled."""
    known, rows = view.result["parameters"], _of(view).rows
    panels: list[Panel] = []
    for name, p in list(known.items())[:MOST_PARAMETERS]:
        seen = sorted((r["pooled"][name][0], k) for k, r in enumerate(rows) if name in r["pooled"])
        at = np.arange(float(len(seen)))
        pooled = np.array([value for value, _ in seen])
        own = np.array(
            [((rows[k].get("values") or {}).get(name) or [np.nan])[0] for _, k in seen], float
        )
        factor, unit = engineering(float(np.abs(pooled).max()), p["unit"])
        marks: tuple[Mark, ...] = (
            Points(at, factor * own, "own data", MUTED, 3.5, 0.7),
            Points(at, factor * pooled, "pooled", AFTER, 4.5, 0.9),
            Level(factor * float(p["mean"]), "common", BEFORE),
        )
        title = f"{name} [{unit}]" if unit else name
        panels.append(Panel(marks, Axis("units in order"), Axis(), title))
    if not panels:
        return None
    alt = f"Values of {', '.join(list(known)[:MOST_PARAMETERS])} over all units, own and partially pooled."
    figure = Figure(
        "fleet_parameters", alt, tuple(panels), 2, height=60 + 200 * (-(-len(panels) // 2))
    )
    table = [
        (
            name, parameter([p["mean"], p["sd"], p["unit"]]),
            *(quantity(p[k], p["unit"]) for k in ("between", "within")), str(p["units"]),
        )
        for name, p in known.items()
    ]  # fmt: skip
    return Section(
        "parameters", "Parameters", (figure,), {"rows": table}, template="fleet_parameters"
    )


def changes(view: View) -> Section | None:
    """What changes: values of recordings along mileage or time."""
    series = _of(view).series
    if not series:
        return None
    panels = tuple(_panel(s) for s in series)
    alt = "; ".join(f"{s.unit}: {change(s.change)}" for s in series)
    figure = Figure("fleet_changes", alt, panels, 2, height=60 + 220 * (-(-len(panels) // 2)))
    return Section("changes", "What changes", (figure,), {"caption": alt}, template="fleet_figure")


def _panel(seen: SeriesView) -> Panel:
    """One series with its deviations, and where the change begins."""
    along = {"mileage": (KM, "mileage [km]"), "recordings": (1.0, "recordings in order")}
    scale, label = along.get(seen.axis, (DAY, "time [days]"))
    x, y, s = seen.x / scale, seen.y, seen.s
    bars = [
        Line(np.array([a, a]), np.array([b - e, b + e]), "", AFTER, 1.0)
        for a, b, e in zip(x, y, s, strict=True)
    ]
    drawn: tuple[Mark, ...] = (
        *bars,
        Points(x, y, "", AFTER, 5.0, 1.0),
        Level(seen.change["at"], "", FLOOR) if seen.change["form"] == "groups"
        else Level(seen.change["at"] / scale, "", FLOOR, vertical=True),
    )  # fmt: skip
    return Panel(drawn, Axis(label), Axis(), f"{seen.unit}: {seen.quantity}")


def planned(view: View) -> Section | None:
    """What to record next, the strangest unit first."""
    rows: Sequence[Mapping[str, Any]] = view.result["record_next"]
    if not rows:
        return None
    told = [(str(r["unit"]), suggested(r)) for r in rows[:MOST_NEXT]]
    return Section(
        "next",
        "What to record next",
        facts={"rows": told, "more": len(rows) - len(told)},
        template="fleet_next",
    )
