"""Which recordings a fleet is made of: where each lies, of which unit it is, and when it was made."""

from __future__ import annotations

import glob
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from er_models.errors import InputError
from er_records.load import READERS, recordings
from er_records.readers.columns import split_header
from er_records.readers.units import UNITS, known_unit

from er_model_lab.fleets.places import filesystem, is_folder, is_url, local, reached

BY = ("folder", "file", "namespace")
"""What may name a unit, beside a column of a table."""
AXES = {"time": "s", "mileage": "m"}
"""Columns along which units change, and their SI units; of a time also dates as ISO 8601 writes them."""
TABLES = (".csv", ".parquet")
FARTHER = {"km": 1e3, "mi": 1609.344}
"""Units of a mileage that no recording has, and their factors."""
LATER = {"d": 86400.0, "h": 3600.0}


@dataclass(frozen=True, slots=True)
class Source:
    """A recording: path or URL, unit ("" where its content tells), time [s], mileage [m], what a table says more."""

    path: str
    unit: str
    time: float | None = None
    mileage: float | None = None
    more: tuple[tuple[str, str], ...] = ()


def sources(data: Sequence[str], by: str | None = None) -> Iterator[Source]:
    """Every recording of folders, globs and tables, local or by URL, in the order given.

    A table is a CSV or Parquet file with a column `path`; paths in it count from its folder. by: what names a unit:
    `folder` (default), `file`, `namespace` (of the topics in a bag), or a column of the tables (default there: `unit`).

    Raises:
        InputError: Nothing there, a table without that column, a cell that is no number.
    """
    for given in data:
        found = False
        for path in _spread(given):
            listed = _listed(path)
            inside = (
                _rows(path, listed, by) if listed is not None else _plain(path, by or "folder")
            )
            for found_one in inside:
                found = True
                yield found_one
        if not found:
            raise InputError(given, "DATA", "at least one recording", "none")


def _spread(given: str) -> Iterator[str]:
    """The paths that a glob stands for, or the path itself."""
    if not glob.has_magic(given) or (not is_url(given) and Path(given).exists()):
        yield given
    elif is_url(given):
        files = filesystem(given)[0]
        with reached(given):
            found = [str(each) for each in files.glob(given, detail=False)]
        yield from map(files.unstrip_protocol, found)
    else:
        yield from sorted(glob.glob(given, recursive=True))


def _plain(path: str, by: str) -> Iterator[Source]:
    """The recordings of a file, folder or URL, whose unit the place names."""
    if by not in BY:
        raise InputError(
            "by", "", f"{', '.join(BY)} where DATA is no table with a column `path`", by
        )
    for one in _inside(path):
        name = Path(one).stem if by == "file" else Path(one).parent.name
        yield Source(one, "" if by == "namespace" else name or "root")


def _inside(path: str) -> Iterator[str]:
    """The recordings below a path."""
    if not is_url(path):
        if not Path(path).exists():
            raise InputError(path, "DATA", "a file or folder", "nothing there")
        yield from (str(each.absolute()) for each in recordings(Path(path)))
        return
    files, inner = filesystem(path)
    with reached(path):
        found = sorted(files.find(inner)) if is_folder(files, inner) else None
    if found is None:
        yield path
        return
    for each in found:
        if Path(each).suffix.lower() in READERS:
            yield files.unstrip_protocol(each)


def _listed(path: str) -> Any:
    """The table that a path is, where it lists recordings; None where it is one."""
    if Path(path).suffix.lower() not in TABLES or not (is_url(path) or Path(path).is_file()):
        return None
    import pyarrow as pa
    from pyarrow import csv, parquet

    with local(path) as file:
        try:
            if file.suffix.lower() == ".parquet":
                if "path" not in parquet.read_schema(file).names:
                    return None
                return parquet.read_table(file)
            with file.open(encoding="utf-8", errors="replace") as stream:
                head = [cell.strip().strip('"') for cell in stream.readline().split(",")]
            if "path" not in head:
                return None
            every = csv.ConvertOptions(column_types=dict.fromkeys(head, pa.string()))
            return csv.read_csv(file, convert_options=every)
        except pa.ArrowInvalid as error:
            raise InputError(
                path, "DATA", "a table of recordings", str(error).splitlines()[0]
            ) from None


def _rows(path: str, table: Any, by: str | None) -> Iterator[Source]:
    """The recordings that a table lists."""
    wanted, names = by or "unit", list(table.column_names)
    if wanted not in (*names, *BY):
        raise InputError(path, "by", f"one of {', '.join((*names, *BY))}", wanted)
    axes = {name: (split_header(name)[0], split_header(name)[1]) for name in names}
    for batch in table.to_batches(4096):
        for row in batch.to_pylist():
            yield _row(path, row, wanted, axes)


def _row(
    path: str, row: Mapping[str, Any], by: str, axes: Mapping[str, tuple[str, str]]
) -> Source:
    """One row of a table as a recording."""
    place = str(row["path"] or "")
    if not place:
        raise InputError(path, "path", "the place of a recording", "an empty cell")
    if not is_url(place) and not Path(place).is_absolute():
        folder = path.rpartition("/")[0] if is_url(path) else str(Path(path).absolute().parent)
        place = f"{folder}/{place}" if folder else place
    if by in row:
        unit = str(row[by] if row[by] is not None else "")
        if not unit:
            raise InputError(path, by, f"the unit of {place}", "an empty cell")
    else:
        unit = next(_plain_unit(place, by))
    known = dict.fromkeys(AXES, None) | {
        name: _number(path, name, stated, row[column])
        for column, (name, stated) in axes.items() if name in AXES
    }  # fmt: skip
    more = tuple(
        (column, str(value)) for column, value in row.items()
        if column not in ("path", by) and axes[column][0] not in AXES and value is not None
    )  # fmt: skip
    return Source(place, unit, known["time"], known["mileage"], more)


def _plain_unit(place: str, by: str) -> Iterator[str]:
    """The unit that a place names."""
    name = Path(place).stem if by == "file" else Path(place).parent.name
    yield "" if by == "namespace" else name or "root"


def _number(path: str, name: str, stated: str, cell: Any) -> float | None:
    """A time [s] or mileage [m]; None for an empty cell."""
    if cell is None or cell == "":
        return None
    if isinstance(cell, datetime):
        return (cell if cell.tzinfo else cell.replace(tzinfo=timezone.utc)).timestamp()
    try:
        value = float(cell) * _factor(path, name, stated)
    except ValueError:
        with suppress(ValueError):
            if name == "time":
                return _number(
                    path, name, stated, datetime.fromisoformat(str(cell).replace("Z", "+00:00"))
                )
        expected = "a number or an ISO date" if name == "time" else "a number"
        raise InputError(path, name, expected, repr(cell)) from None
    return value if math.isfinite(value) else None


def _factor(path: str, name: str, stated: str) -> float:
    """What turns the stated unit into SI."""
    si, beside = AXES[name], FARTHER if name == "mileage" else LATER
    unit = known_unit(si, stated) if stated else si
    if unit is None and stated not in beside:
        raise InputError(path, name, f"a unit: {', '.join((*UNITS[si], *beside))}", stated)
    return beside[stated] if unit is None else UNITS[si][unit]
