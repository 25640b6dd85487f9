"""Rows of a table that is too long for the page: files beside it, read when they are looked at, also offline."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import islice
from pathlib import Path

from er_records.write import finished_only

from er_model_lab.output.report.embed import compact, inflatable

CHUNK = 5000
"""Rows of a file."""


def names(table: str, count: int) -> list[str]:
    """Files that `count` rows of a table lie in, relative to the page."""
    return [f"{table}/{k:04d}.js" for k in range(-(-count // CHUNK))]


def write_rows(folder: Path, table: str, rows: Iterable[Sequence[str]]) -> None:
    """Write the rows, and remove the files of an earlier report that held more; `OSError` where that cannot be."""
    left, written = iter(rows), 0
    while together := list(islice(left, CHUNK)):
        name = f"{table}/{written:04d}.js"
        with finished_only(folder / name) as part:
            part.write_text(f'erRows("{name}","{inflatable(compact(together))}");\n', "ascii")
        written += 1
    while (stale := folder / f"{table}/{written:04d}.js").is_file():
        stale.unlink()
        written += 1
