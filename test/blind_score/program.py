"""What the score programs share: seeds, a results file that is gone on with, progress, and the end."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from er_common.versions import versions
from er_models.errors import ErError, InputError
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from test.blind_score.pool import spread
from test.blind_score.rows import append, digest, read

J = TypeVar("J")
Rows = list[dict[str, Any]]


def parser_of(name: str, text: str | None) -> argparse.ArgumentParser:
    """The options that every score program has."""
    parser = argparse.ArgumentParser(prog=name, description=text)
    parser.add_argument("--seeds", nargs="+", default=["1"], help="numbers, or ranges like 1-10")
    parser.add_argument("--workers", type=int, default=2, help="processes, one thread each")
    parser.add_argument("--results", type=Path, help="JSON lines: noted here, and gone on with")
    parser.add_argument("--noted", action="store_true", help="make nothing, show what is noted")
    parser.add_argument("--table", type=Path, help="write the tables here as well")
    return parser


def seeds_of(words: list[str]) -> list[int]:
    """Seeds from words like ``3`` and ``1-10``.

    Raises:
        InputError: a word that is neither.
    """
    found: list[int] = []
    for word in words:
        first, _, last = word.partition("-")
        if not first.isdigit() or (last and not last.isdigit()):
            raise InputError("--seeds", "", "numbers like 3 or 1-10", word)
        found += range(int(first), int(last or first) + 1)
    return found


def collect(
    given: argparse.Namespace,
    asked: Mapping[str, J],
    work: Callable[[J], dict[str, Any]],
    fits: Callable[[dict[str, Any]], bool] = lambda row: True,
    code: str = "",
) -> Rows:
    """Rows of all cases asked for, by key: those known already from this code, and those made now."""
    made_by = code or digest()
    known = read(given.results) if given.results else ()
    rows = {r["key"]: r for r in known if r.get("code") == made_by and fits(r)}
    wanted = [job for key, job in asked.items() if key not in rows and not given.noted]
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=Console(stderr=True), disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task("cases", total=len(asked), completed=len(asked) - len(wanted))
        for row in spread(work, wanted, given.workers):
            row |= {"code": made_by, "version": versions()["er_model_lab"]}
            rows[row["key"]] = row
            if given.results:
                append(given.results, row)
            bar.update(task, advance=1, description=row["key"])
    return [rows[key] for key in asked if key in rows]


def heading(given: argparse.Namespace, rows: Rows) -> str:
    """What was run, with which code."""
    made_by = rows[0]["code"] if rows else digest()
    version = versions()["er_model_lab"]
    return f"Seeds {' '.join(given.seeds)}, {len(rows)} cases; er_model_lab {version}, code {made_by}."


def finish(given: argparse.Namespace, make: Callable[[], str]) -> int:
    """Print and write the page; status 2 with one line where something is wrong with what was asked."""
    try:
        text = make()
    except ErError as error:
        sys.stderr.write(f"{' '.join(str(error).split())}\n")
        return error.exit_status
    if given.table:
        given.table.write_text(text, encoding="utf-8")
    sys.stdout.write(text)
    return 0
