"""`./er study fault_statistics`: what the fault estimator says in large numbers of drives, with faults and without."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from er_models.errors import InputError
from er_models.files import load_model
from rich.console import Console
from rich.progress import track
from rich.table import Table

from er_studies.faults.statistics import CLOSE, GROUPS, IN_TIME, Found, Group, statistics
from er_studies.programs import program_of, run

_ROADS = ("iso8608", "round bumps", "sharp bumps", "tone", "chirp")


def fault_statistics_command(
    groups: Annotated[
        list[str] | None, typer.Argument(help="Kinds of drives, by their names; all where none.")
    ] = None,
    model: Annotated[Path, typer.Option(help="Vehicle model file.")] = Path(
        "config/vehicles/inove_quarter_car.yaml"
    ),
    number: Annotated[int, typer.Option(min=1, help="Drives of each kind.")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all drives.")] = 1,
) -> None:
    """Drive on roads of every kind, with parameters off by up to 5 %: faults, none, friction, load."""
    names = {group.name: group for group in GROUPS}
    for name in groups or ():
        if name not in names:
            raise InputError("fault_statistics", "GROUPS", "of " + "; ".join(names), name)
    asked = [names[name] for name in groups or names]
    console = Console(stderr=True)
    jobs = statistics(asked, load_model(model), seed, number)
    found: dict[str, list[Found]] = {group.name: [] for group in asked}
    shown = track(
        jobs, total=len(asked) * number, console=console, disable=not console.is_terminal
    )
    for group, each in shown:
        found[group.name].append(each)
    _print(Console(width=160), asked, found, seed)


def _print(
    console: Console, asked: Sequence[Group], found: dict[str, list[Found]], seed: int
) -> None:
    """The tables of drives without faults and with."""
    quiet = Table(
        "drives", "road", "number", "a fault named", "one that is open", "unexplained", "of the time",
        title=f"No fault, seed {seed}",
    )  # fmt: skip
    faulty = Table(
        "drives", "road", "number", f"named within {IN_TIME:g} s", f"all factors within {CLOSE:g} then", "at the end",
        "median s to name", "another fault named", "unexplained at the end", title=f"Faults, seed {seed}",
    )  # fmt: skip
    for group in asked:
        for road in ("all", *_ROADS):
            some = [f for f in found[group.name] if road == "all" or f.road.startswith(road)]
            if some:
                table, cells = (faulty, _faulty(some)) if group.left else (quiet, _quiet(some))
                table.add_row(group.name if road == "all" else "", road, str(len(some)), *cells)
    for table in (quiet, faulty):
        if table.row_count:
            console.print(table)


def _quiet(some: Sequence[Found]) -> list[str]:
    share = 100.0 * float(np.mean([f.unexplained for f in some]))
    named, left_open = [bool(f.wrong) for f in some], [f.left_open for f in some]
    doubted = [f.unexplained > 0.0 for f in some]
    return [*(_count(some, yes) for yes in (named, left_open, doubted)), f"{share:.1f} %"]


def _faulty(some: Sequence[Found]) -> list[str]:
    return [
        _count(some, [f.named <= IN_TIME for f in some]), _count(some, [f.error <= CLOSE for f in some]),
        _count(some, [f.last_error <= CLOSE for f in some]), f"{np.median([f.named for f in some]):.1f}",
        _count(some, [bool(f.wrong) for f in some]), _count(some, [f.doubted for f in some]),
    ]  # fmt: skip


def _count(some: Sequence[Found], yes: Sequence[bool]) -> str:
    return f"{sum(yes)} ({100.0 * sum(yes) / len(some):.1f} %)"


app = program_of(fault_statistics_command)

if __name__ == "__main__":
    run(app)
