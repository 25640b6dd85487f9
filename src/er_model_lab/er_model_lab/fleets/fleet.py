"""Many dampers: which of them differ, in what, and since when?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from er_common.command_line import command_line
from er_common.extras import extra
from er_common.versions import versions
from er_models.errors import ErError, InputError
from er_models.model import Model

from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.fleets.asked import Asked, code
from er_model_lab.fleets.engine import Engine, Lost, OtherCode
from er_model_lab.fleets.overview import Overview, overview
from er_model_lab.fleets.run import Run
from er_model_lab.fleets.source import sources
from er_model_lab.fleets.store import Store
from er_model_lab.results.fleet import FleetResult
from er_model_lab.results.fleet_view import fleet_view, value_in
from er_model_lab.results.values import clean
from er_model_lab.view import View
from er_model_lab.work import STOPPED, Event, Progress, Work

ENDED = (Lost, OtherCode)
"""What ends a run early: whoever did the work is gone, or is another by now."""
SHOWN_SAMPLES = 5_000_000
"""Samples of which a run keeps what pages show, some 300 MB; of further units it is found again for their page."""
MOST_FAILED = 20
"""Recordings without a result that the JSON names; the table has all."""


def fleet(
    data: str | Path | Sequence[str | Path],
    model: Model,
    *,
    out: str | Path,
    by: str | None = None,
    search: bool = True,
    resume: bool = False,
    cluster: str | None = None,
    security: Any = None,
    workers: int | None = None,
    most: int = 20,
    reports: int = 0,
    seed: int = 0,
    rule: Rule = RULE,
    anyway: bool = False,
    progress: Progress | None = None,
    cancel: Event | None = None,
    executor: Executor | None = None,
) -> FleetResult:
    """Compare, identify and diagnose every unit of a fleet, and set them beside one another.

    data: folders, globs, URLs, or tables with a column `path`; out: the table of the units (.parquet), beside which
    `<out>.recordings.parquet` and the results so far, `<out>.results`, are written; by: what names a unit, see
    `er_model_lab.fleets.source`; search: whether effects are searched for; resume: go on from `<out>.results`;
    cluster: address of a Dask scheduler, else Dask's processes on this machine; security: for `tls://`; workers: how
    many processes; most: recordings that a unit is diagnosed with; reports: how
    many of the units that differ get a page of their own in `report`; executor: does the work in Dask's place.

    A script that calls this without `cluster` guards itself with `if __name__ == "__main__":`, as Dask's processes read
    it again.

    Raises:
        InputError: No recordings, a place that cannot be written, a scheduler that does not answer. A table that
            cannot be written at the end is in `errors` of the result.
        OtherCode, Lost: Workers have other versions, or are gone, before any recording was read; later that is in
            `errors`, too.
        Cancelled: It was stopped before any recording was read.
    """
    table = _parquet(Path(out))
    given = [str(d) for d in ([data] if isinstance(data, str | Path) else data)]
    asked = Asked(model, seed, rule, anyway, search, most, by == "namespace")
    work = Work(progress=progress, cancel=cancel)
    with (
        closing(Store(table.with_suffix(".results"))) as store,
        _engine(executor, cluster, workers, security) as engine,
    ):
        store.add(sources(given, by))
        run = Run(store, asked, engine, work, resume, SHOWN_SAMPLES if reports else 0)
        interrupted, error = _worked(run)
        work.wind_up()
        return _result(run, table, reports, error, interrupted=interrupted)


def _parquet(out: Path) -> Path:
    """The place of the table; `InputError` where it is no Parquet file."""
    if out.suffix.lower() != ".parquet":
        raise InputError(out, "--out", "a file name that ends in .parquet", f"'{out.suffix}'")
    return out


@contextmanager
def _engine(
    executor: Executor | None, address: str | None, workers: int | None, security: Any
) -> Iterator[Engine]:
    """Who does the work."""
    if executor is not None:
        yield Engine(executor, workers or int(getattr(executor, "_max_workers", 1)))
        return
    from er_model_lab.fleets.cluster import cluster

    with cluster(address, workers=workers, security=security) as engine:
        yield engine


def _worked(run: Run) -> tuple[bool, ErError | None]:
    """Do the work; whether it was stopped, and what ended it early when something was done."""
    try:
        run.recordings()
        run.units()
    except STOPPED:
        return True, None
    except ENDED as error:
        if not run.store.count("part"):
            raise
        return False, error
    return False, None


def _result(
    run: Run, table: Path, reports: int, error: ErError | None, *, interrupted: bool
) -> FleetResult:
    """Write the tables, and say what they show; error: what ended the run early."""
    store, model = run.store, run.asked.model
    found = overview(store.rows(), store.parts())
    written, errors = _written(run, found, table)
    strange = [d["unit"] for d in found.content["differ"][:reports]]
    pages: dict[str, bytes] = {}
    try:
        pages = run.pages(strange) if strange and not (interrupted or error is not None) else {}
    except STOPPED:
        interrupted = True
    except ENDED as late:
        error = late
    errors = [*([] if error is None else [error]), *errors]
    failed = [
        _failed(p) for s in ("unreadable", "not_usable", "failed") for p in store.parts(status=s)
    ]
    notes = (
        *map(str, errors),
        *_notes(run, found, len(failed), early=interrupted or error is not None),
    )
    origin = {"model": model.digest(), "model_file": model.file, "seed": run.asked.seed, "versions": versions(),
              "command_line": command_line(), "code": code()}  # fmt: skip
    content = {
        "command": "fleet", "model": model.name, **found.content, "reused": run.reused,
        "tables": written, "failed": failed[:MOST_FAILED], "notes": list(notes),
        "complete": not (failed or interrupted or errors), "provenance": origin,
    }  # fmt: skip
    places = {unit: f"units/{k:02d}.html" for k, unit in enumerate(strange) if unit in pages}
    seen = fleet_view(
        store.rows(),
        found.units,
        found.content["differ"],
        lambda u: store.parts(u, "used"),
        places,
    )
    view = View(
        "fleet", model.name, _headline(found), clean(content), (), notes=notes, provenance=origin, fleet=seen
    )  # fmt: skip
    drawn = {place: pages[unit] for unit, place in places.items()}
    return FleetResult(view, interrupted=interrupted, pages=drawn, errors=tuple(errors))


def _written(run: Run, found: Overview, table: Path) -> tuple[dict[str, str], list[ErError]]:
    """The tables that could be written, and what was said of those that could not."""
    with extra("er_model_lab[fleet]", "a table of a fleet"):
        from er_model_lab.fleets import tables
    store, model = run.store, run.asked.model
    about = {"model": model.digest(), "command_line": command_line(), "seed": str(run.asked.seed)}
    more = dict.fromkeys(name for part in store.parts() for name in part["more"])
    beside = table.with_suffix(".recordings.parquet")
    written, errors = dict[str, str](), list[ErError]()
    for what, columns, rows, place in (
        ("units", tables.unit_columns(model), _unit_rows(store, found), table),
        (
            "recordings",
            tables.recording_columns(model, more),
            _recording_rows(store, found),
            beside,
        ),
    ):
        try:
            tables.write(columns, rows, place, about)
            written[what] = str(place)
        except InputError as error:
            errors.append(error)
    return written, errors


def _unit_rows(store: Store, found: Overview) -> Iterator[dict[str, Any]]:
    """Rows of the units as the table holds them."""
    for row in store.rows():
        told = found.units[row["unit"]]
        values = {name: v for name, v in (row.get("values") or {}).items() if v[0] is not None}
        flat = {name: v[0] for name, v in values.items()} | {
            f"{name}_sd": v[1] for name, v in values.items()
        }
        for name, (value, sd, _) in told["pooled"].items():
            flat |= {f"{name}_pooled": value, f"{name}_pooled_sd": sd}
        yield {
            **row, **flat, **told, "next": [_asked_for(each) for each in told["next"]],
            "values": [{"name": n, "value": v, "sd": sd, "unit": u} for n, (v, sd, u) in values.items()],
        }  # fmt: skip


def _recording_rows(store: Store, found: Overview) -> Iterator[dict[str, Any]]:
    """Rows of the recordings as the table holds them, each with its damper where its unit seems to hold two."""
    halves = {
        unit: next((c for c in told["changes"] if c["form"] == "groups"), None)
        for unit, told in found.units.items()
    }
    for part in store.parts():
        known = {n: v for n, v in (part.get("values") or {}).items() if v[0] is not None}
        values = {n: v[0] for n, v in known.items()} | {f"{n}_sd": v[1] for n, v in known.items()}
        yield {**part["more"], **part, **values, "damper": _damper(part, halves.get(part["unit"]))}


def _damper(part: Mapping[str, Any], groups: Mapping[str, Any] | None) -> int | None:
    """Which of two dampers a recording is of, by the groups of its unit."""
    if groups is None:
        return None
    value, _ = value_in(groups["quantity"], part)
    return None if value is None else 1 + (value > groups["at"])


def _asked_for(each: dict[str, Any]) -> str:
    """A suggestion in words."""
    what = (
        f"tell {' and '.join(each['between'])} apart" if "between" in each
        else f"reveal {each['reveal']}" if "reveal" in each else str(each["record"])
    )  # fmt: skip
    return f"{what}: {each['why']}"


def _failed(part: dict[str, Any]) -> dict[str, Any]:
    """A recording that gave nothing, and why."""
    return {key: part.get(key) for key in ("unit", "path", "record", "status", "error")}


def _notes(run: Run, found: Overview, failed: int, *, early: bool) -> tuple[str, ...]:
    """What to know of the run."""
    content, notes = found.content, list[str]()
    if early:
        notes.append("ended early: the tables hold what was done; resume=True goes on from there")
    if failed:
        notes.append(
            f"{failed} of {content['recordings']} records gave nothing: see status and error in the table"
        )
    if copies := content["statuses"].get("copy"):
        notes.append(f"{copies} recordings hold the same samples as another one: used once")
    if run.lost:
        notes.append(
            f"{run.store.file} could not be written ({run.lost}): resume=True would repeat some"
        )
    if run.store.full:
        notes.append(
            f"the folder of temporary files ({run.store.full}) had no room: rows stayed in memory"
        )
    if common := content["common_effects"]:
        notes.append(
            f"most units show {' and '.join(common)}: add what is common to the model, then ask again"
        )
    return tuple(notes)


def _headline(found: Overview) -> str:
    """One line: how many units, and how many differ."""
    c = found.content
    differ = len(c["differ"])
    return (
        f"{c['units']} unit{'s' * (c['units'] != 1)}, {c['recordings']} recordings: "
        f"{differ} unit{'s' * (differ != 1)} differ{'s' * (differ == 1)} from the others"
    )
