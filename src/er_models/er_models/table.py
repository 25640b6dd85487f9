"""Two columns of a table file, CSV or Parquet: time and one signal."""

from __future__ import annotations

import csv
from importlib import import_module
from pathlib import Path

import numpy as np

from er_models.arrow import Array, samples
from er_models.errors import InputError


def read_columns(path: Path, time: str, signal: str) -> tuple[Array, Array]:
    """Time [s] and signal, each (n,), time strictly increasing, all finite.

    Raises `InputError`: no file, another kind of file, no such column, no numbers, time not
    increasing.
    """
    if not path.is_file():
        raise InputError(
            path, "", "a .csv or .parquet file", "no file" if not path.exists() else "a folder"
        )
    readers = {".csv": _read_csv, ".parquet": _read_parquet}
    if path.suffix not in readers:
        raise InputError(path, "", "a .csv or .parquet file", f"'{path.suffix}'")
    t, y = readers[path.suffix](path, (time, signal))
    for name, column in ((time, t), (signal, y)):
        bad = np.flatnonzero(~np.isfinite(column))
        if bad.size:
            raise InputError(path, f"{name}, row {bad[0] + 1}", "a finite number", column[bad[0]])
    late = np.flatnonzero(np.diff(t) <= 0.0)
    if t.size < 2 or late.size:
        where = f"{time}, row {late[0] + 2}" if late.size else time
        found = f"{t[late[0] + 1]:g} after {t[late[0]]:g}" if late.size else f"{t.size} rows"
        raise InputError(path, where, "two or more increasing times", found)
    return t, y


def _read_csv(path: Path, names: tuple[str, str]) -> list[Array]:
    """Columns of a comma-separated file with a header."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = csv.reader(file)
            header = [h.strip() for h in next(rows, [])]
            places = [_place(path, header, name) for name in names]
            columns: list[list[float]] = [[], []]
            for number, row in enumerate(rows, start=1):
                for column, place, name in zip(columns, places, names, strict=True):
                    column.append(_number(path, f"{name}, row {number}", row, place))
    except UnicodeDecodeError as error:
        raise InputError(path, "", "a text file in UTF-8", "other bytes") from error
    return [np.array(c, float) for c in columns]


def _read_parquet(path: Path, names: tuple[str, str]) -> list[Array]:
    """Columns of a Parquet file; needs pyarrow, which the pure library otherwise does not."""
    try:
        pyarrow = import_module("pyarrow")
        parquet = import_module("pyarrow.parquet")
    except ImportError as error:
        raise InputError(
            path, "", "pyarrow to be installed for Parquet files", "no pyarrow"
        ) from error
    try:
        table = parquet.read_table(path)
    except (pyarrow.ArrowException, OSError) as error:
        raise InputError(path, "", "a Parquet file", str(error).splitlines()[0]) from error
    columns = []
    for name in names:
        _place(path, table.column_names, name)
        try:
            columns.append(samples(table[name]))
        except pyarrow.ArrowException as error:
            raise InputError(path, name, "a column of numbers", str(table[name].type)) from error
    return columns


def _place(path: Path, header: list[str], name: str) -> int:
    """Place of a column."""
    if name not in header:
        raise InputError(
            path, name, "a column of that name", f"columns {', '.join(header) or 'none'}"
        )
    return header.index(name)


def _number(path: Path, where: str, row: list[str], place: int) -> float:
    """One cell as a number."""
    cell = row[place] if place < len(row) else ""
    try:
        return float(cell)
    except ValueError:
        raise InputError(path, where, "a number", repr(cell)) from None
