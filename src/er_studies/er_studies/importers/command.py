"""`./er study import KIND SOURCE --out DIR`: a measured data set in the contract's columns."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Literal, TypeVar

import typer
from er_models.errors import ErError
from er_records.record import Record
from er_records.write import finished_only, write_csv, write_parquet
from rich.console import Console
from rich.progress import track

from er_studies.programs import program_of, run

T = TypeVar("T")

KINDS = ("mts", "shaking_table", "piston_seal")
"""Data sets of `data_sets`, which are loaded with what they need once one is asked for."""
KEPT_BESIDE = ("LICENSE", "SOURCE.txt")
"""Files that go with any copy of a data set."""


def import_command(
    kind: Annotated[str, typer.Argument(help=f"Data set: {', '.join(KINDS)}.")],
    source: Annotated[Path, typer.Argument(help="Folder of the data set, or one of its files.")],
    out: Annotated[Path, typer.Option("--out", help="Folder for the result.")],
    form: Annotated[
        Literal["parquet", "csv"], typer.Option("--format", help="File format.")
    ] = "parquet",
) -> None:
    """Convert a measured data set; its parts (train, held out) go to folders of their own."""
    from er_studies.importers.data_sets import import_data

    try:
        records = import_data(kind, source, lambda files: _shown("reading", files))
        written = _write(kind, records, out, form)
        for name in KEPT_BESIDE:
            _keep(source if source.is_dir() else source.parent, name, out)
    except ErError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(error.exit_status) from None
    except OSError as error:
        typer.echo(
            f"{out}: expected a folder that can be written, found {error.strerror}", err=True
        )
        raise typer.Exit(2) from None
    for folder, number in sorted(written.items()):
        typer.echo(f"{folder}: {number} records")


def _write(kind: str, records: Sequence[Record], out: Path, form: str) -> dict[Path, int]:
    """Write all records; returns the number in each folder."""
    from er_studies.importers.data_sets import part_of

    writer = write_csv if form == "csv" else write_parquet
    written: dict[Path, int] = {}
    for record in _shown("writing", records):
        folder = out / part_of(kind, record)
        writer(record, folder / f"{record.name}.{form}")
        written[folder] = written.get(folder, 0) + 1
    return written


def _shown(title: str, items: Sequence[T]) -> Iterable[T]:
    """The items behind a progress bar, which only a terminal shows."""
    quiet = not sys.stderr.isatty()
    return track(items, title, console=Console(stderr=True), disable=quiet, transient=True)


def _keep(folder: Path, name: str, out: Path) -> None:
    """Copy a file that must stay with the data, when it is there."""
    if (folder / name).is_file():
        with finished_only(out / name) as part:
            shutil.copyfile(folder / name, part)


app = program_of(import_command)

if __name__ == "__main__":
    run(app)
