"""Scores the lab on blind data: ``./er exec python -m test.blind_score --kinds singles --seeds 1-10``.

Prints the shares against their targets as Markdown. With ``--results`` every case is noted as soon as it
is known, and a second run makes only what is missing or was made by other code.
"""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path
from typing import Any

from er_model_lab.versions import versions
from er_models.errors import ErError, InputError
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from test.blind_score.cases import KINDS, Layout, known, plan
from test.blind_score.judge import judged
from test.blind_score.pool import spread
from test.blind_score.rows import append, digest, read
from test.blind_score.run import score
from test.blind_score.summary import ordered, page


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


def arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="blind_score", description=__doc__)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, help="by default all")
    parser.add_argument("--seeds", nargs="+", default=["1"], help="numbers, or ranges like 1-10")
    parser.add_argument("--effects", nargs="+", help="only these names, `none`, `outside:KIND`")
    parser.add_argument("--workers", type=int, default=2, help="processes, one thread each")
    parser.add_argument("--results", type=Path, help="JSON lines: noted here, and gone on with")
    parser.add_argument("--table", type=Path, help="write the tables here as well")
    parser.add_argument("--records", type=int, help="records a case; else 1 to 3")
    parser.add_argument("--seconds", type=float, help="length of a record; else 40 to 90 s")
    return parser.parse_args(argv)


def checked(given: argparse.Namespace) -> Layout | None:
    """The layout asked for, if any.

    Raises:
        InputError: an unknown effect, or only half a layout.
    """
    for name in given.effects or []:
        if not known(name):
            raise InputError("--effects", "", "an effect of the generator, or none", name)
    if (given.records is None) != (given.seconds is None):
        raise InputError("--records", "", "--records and --seconds together", "one of them")
    return Layout(given.records, given.seconds) if given.records else None


def collect(given: argparse.Namespace) -> list[dict[str, Any]]:
    """Rows of all cases asked for: those known already, and those made now."""
    size, made_by = checked(given), digest()
    asked = plan(given.kinds or KINDS, seeds_of(given.seeds), given.effects)
    rows = {r["key"]: r for r in (read(given.results) if given.results else ())}
    rows = {k: r for k, r in rows.items() if fits(r, made_by, size)}
    wanted = [a for a in asked if a.key not in rows]
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task("cases", total=len(asked), completed=len(asked) - len(wanted))
        for row in spread(partial(score, size=size), wanted, given.workers):
            row |= {"code": made_by, "version": versions()["er_model_lab"]}
            rows[row["key"]] = row
            if given.results:
                append(given.results, row)
            bar.update(task, advance=1, description=f"{row['key']}: {judged(row)}")
    return [rows[a.key] for a in asked]


def fits(row: dict[str, Any], made_by: str, size: Layout | None) -> bool:
    """Whether a row known already answers what is asked now."""
    same = size is None or (row["records"], row["seconds"]) == (size.records, size.seconds)
    return same and row.get("code") == made_by


def heading(given: argparse.Namespace, rows: list[dict[str, Any]]) -> str:
    """What was run, with which code."""
    seeds, made_by = " ".join(given.seeds), rows[0]["code"] if rows else digest()
    return f"Seeds {seeds}, {len(rows)} cases; er_model_lab {versions()['er_model_lab']}, code {made_by}."


def main(argv: list[str] | None = None) -> int:
    """Command line; status 2 with one line where something is wrong with what was asked."""
    given = arguments(argv)
    try:
        rows = collect(given)
    except ErError as error:
        sys.stderr.write(f"{' '.join(str(error).split())}\n")
        return error.exit_status
    text = page(ordered(rows), heading(given, rows))
    if given.table:
        given.table.write_text(text, encoding="utf-8")
    sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
