"""What a study gives out: tables for people; figures for programs are `er_models.files.write_json`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from er_models.files import write_json, write_whole
from rich.console import Console

Out = Annotated[Path | None, typer.Option(help="Write the tables here as well.")]
Json = Annotated[Path | None, typer.Option("--json", help="Write the figures here.")]


class Table(NamedTuple):
    """Cells of a table under their head, and what stands above it."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    title: str = ""


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def markdown(told: Table) -> str:
    """A table in Markdown, below its title."""
    return f"{told.title}\n\n{table(told.head, told.rows)}".lstrip()


def give(tables: Iterable[Table], file: Path | None, **figures: Any) -> None:
    """Print tables in Markdown; file: gets them, and more figures by their names, as JSON."""
    tables = list(tables)
    say("\n".join(map(markdown, tables)))
    write_json(file, {**figures, "tables": [each._asdict() for each in tables]})


def seconds(times: Sequence[float]) -> str:
    """The median of times, some of which may be infinite [s]."""
    middle = float(np.median(times))
    return f"{middle:.1f}" if np.isfinite(middle) else "never"


def say(text: str, out: Path | None = None) -> None:
    """Print Markdown, for people and for files: no wrapping, no colours; out: a file that gets it as well."""
    Console(soft_wrap=True, markup=False, highlight=False).print(text)
    if out is not None:
        write_whole(out, text + "\n")
