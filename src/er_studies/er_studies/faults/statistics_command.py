"""`./er study fault_statistics`: what the fault estimator says in large numbers of drives, with faults and without."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from er_models.errors import InputError
from er_models.files import load_model, write_json
from rich.console import Console
from rich.progress import track

from er_studies.faults.statistics import (
    CLOSE,
    GROUPS,
    IN_TIME,
    LEARNT,
    Found,
    plain,
    read,
    statistics,
)
from er_studies.given_out import Table, give, seconds
from er_studies.programs import program_of, run

_MOVED = f"all that moved {LEARNT:g} s before"
_ROADS = ("iso8608", "round bumps", "sharp bumps", "tone", "chirp")
_QUIET_HEAD = [
    "drives without a fault", "road", "number", "a fault named", "one that is open", "unexplained", "of the time",
]  # fmt: skip
_FAULTY_HEAD = [
    "drives with a fault", "road", "number", f"named within {IN_TIME:g} s", f"all factors within {CLOSE:g} then",
    "at the end", "median s to name", "another fault named", "unexplained at the end",
]  # fmt: skip
KEPT = 20
"""After so many drives the file is written anew."""


def fault_statistics_command(
    groups: Annotated[
        list[str] | None, typer.Argument(help="Kinds of drives, by their names; all where none.")
    ] = None,
    model: Annotated[Path, typer.Option(help="Vehicle model file.")] = Path(
        "config/vehicles/inove_quarter_car.yaml"
    ),
    number: Annotated[int, typer.Option(min=1, help="Drives of each kind.")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all drives.")] = 1,
    json_file: Annotated[
        Path | None,
        typer.Option(
            "--json",
            help="Write every drive here; goes on after those that the same code has written.",
        ),
    ] = None,
) -> None:
    """Drive on roads of every kind, with parameters off by up to 5 %: faults, none, friction, load."""
    names = {group.name: group for group in GROUPS}
    for name in groups or ():
        if name not in names:
            raise InputError("fault_statistics", "GROUPS", "of " + "; ".join(names), name)
    asked = [names[name] for name in groups or names]
    found = _known(json_file, seed, [group.name for group in asked])
    console = Console(stderr=True)
    jobs = statistics(
        asked, load_model(model), seed, number, {n: len(d) for n, d in found.items()}
    )
    left = sum(max(number - len(drives), 0) for drives in found.values())
    shown = track(jobs, total=left, console=console, disable=not console.is_terminal)
    for done, (group, each) in enumerate(shown, 1):
        found[group.name].append(each)
        if done % KEPT == 0:
            write_json(json_file, {"seed": seed, "drives": plain(found)})
    titled = [each._replace(title=f"seed {seed}") for each in tables(found)]
    give(titled, json_file, seed=seed, drives=plain(found))


def _known(file: Path | None, seed: int, asked: Sequence[str]) -> dict[str, list[Found]]:
    """Drives of these kinds that a file holds."""
    stored: dict[str, Any] = {"seed": seed, "drives": {}}
    if file is not None and file.exists():
        stored = json.loads(file.read_text(encoding="utf-8"))
        if stored["seed"] != seed:
            raise InputError(file, "", f"drives of seed {seed}", f"of seed {stored['seed']}")
    none: dict[str, list[Found]] = {name: [] for name in asked}
    return none | read(stored["drives"])


def tables(found: Mapping[str, Sequence[Found]]) -> list[Table]:
    """Of the drives without faults, and of those with; none where there is no drive."""
    made = []
    for faulty, head, cells in ((False, _QUIET_HEAD, _quiet), (True, _FAULTY_HEAD, _faulty)):
        rows = []
        for group in (g for g in GROUPS if bool(g.left) is faulty):
            drives = found.get(group.name, ())
            moved = (_MOVED,) if faulty and not group.from_start else ()
            for road in ("all", *moved, *_ROADS):
                if some := [f for f in drives if _of(road, f)]:
                    name = group.name if road == "all" else ""
                    rows.append([name, road, str(len(some)), *cells(some)])
        if rows:
            made.append(Table(head, rows))
    return made


def _of(road: str, drive: Found) -> bool:
    """Whether a drive counts in a line of a table."""
    if road == _MOVED:
        return drive.moved_before >= LEARNT
    return road == "all" or drive.road.startswith(road)


def _quiet(some: Sequence[Found]) -> list[str]:
    share = 100.0 * float(np.mean([f.unexplained for f in some]))
    named, left_open = [bool(f.wrong) for f in some], [f.left_open for f in some]
    doubted = [f.unexplained > 0.0 for f in some]
    return [*(_count(some, yes) for yes in (named, left_open, doubted)), f"{share:.1f} %"]


def _faulty(some: Sequence[Found]) -> list[str]:
    return [
        _count(some, [f.named <= IN_TIME for f in some]), _count(some, [f.error <= CLOSE for f in some]),
        _count(some, [f.last_error <= CLOSE for f in some]), seconds([f.named for f in some]),
        _count(some, [bool(f.wrong) for f in some]), _count(some, [f.doubted for f in some]),
    ]  # fmt: skip


def _count(some: Sequence[Found], yes: Sequence[bool]) -> str:
    return f"{sum(yes)} ({100.0 * sum(yes) / len(some):.1f} %)"


app = program_of(fault_statistics_command)

if __name__ == "__main__":
    run(app)
