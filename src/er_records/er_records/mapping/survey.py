"""The columns of files as they are stored: unit, range, rate and samples of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from er_common.extras import extra
from er_models.errors import InputError

from er_records.load import BAG_SUFFIXES, TABLES, recordings
from er_records.readers.columns import Column, split_header
from er_records.readers.names import NAMES_FILE
from er_records.readers.table import Table
from er_records.record import Array

LOOKED_AT = 20
"""Files of a folder whose samples are read, evenly chosen; a full scale is that of these."""


@dataclass(frozen=True, eq=False)
class Seen:
    """One column of one or several files.

    header: as it stands there; name, unit: its parts; low, high: over all files looked at, as stored; rate [Hz], nan
    where no time is known; samples (n,): of the first file that holds it; file: that file; times (n,): its own [s].
    """

    header: str
    name: str
    unit: str
    low: float
    high: float
    samples: Array
    file: Path
    rate: float = float("nan")
    times: Array | None = None


@dataclass(frozen=True, eq=False)
class Survey:
    """The columns of a file or folder; names_file: where their mapping belongs."""

    path: Path
    files: tuple[Path, ...]
    columns: tuple[Seen, ...]
    names_file: Path


def survey(path: Path) -> Survey:
    """The columns of a file, or of the files of a folder.

    Raises:
        InputError: Nothing there, no measurement, a damaged file.
    """
    if not path.exists():
        raise InputError(path, "", "a file or folder", "nothing there")
    files = recordings(path)
    if not files:
        raise InputError(path, "", f"files ending in {', '.join(TABLES)}, or a bag", "none")
    step = max(1, len(files) // LOOKED_AT)
    found: dict[str, Seen] = {}
    for file in files[::step]:
        for seen in _columns(_table(file)):
            first = found.get(seen.header)
            found[seen.header] = seen if first is None else _joined(first, seen)
    columns = tuple(found.values())
    if not columns:
        raise InputError(path, "columns", "numbers", "none")
    folder = path if path.is_dir() else path.parent
    return Survey(path, tuple(files), columns, folder / NAMES_FILE)


def _table(file: Path) -> Table:
    """The columns of one recording."""
    if file.is_dir() or file.suffix.lower() in BAG_SUFFIXES:
        with extra("er_records[bags]", f"{file}: a bag"):
            from er_records.readers.bag_table import table

        return table(file)
    if file.suffix.lower() not in TABLES:
        raise InputError(file, "suffix", f"one of {', '.join(TABLES)}", f"'{file.suffix}'")
    return TABLES[file.suffix.lower()](file)


def _columns(table: Table) -> list[Seen]:
    """The columns of a table that hold numbers and vary or not."""
    samples = _numbers(table)
    out = []
    for index, y in samples.items():
        good = y[np.isfinite(y)]
        if not good.size:
            continue
        header = table.header[index].strip().strip('"').strip()
        name, unit = split_header(header)
        seen = Seen(header, name, unit, float(good.min()), float(good.max()), y, table.path)
        times = table.times(index) if table.times is not None else None
        out.append(replace(seen, times=times if times is not None and times.size else None))
    return out


def _numbers(table: Table) -> Mapping[int, Array]:
    """Samples of the columns that are numbers, by place."""
    every = [Column(i, name, 1.0, "") for i, name in enumerate(table.header) if name.strip()]
    try:
        return _read(table, every)
    except InputError:
        found: dict[int, Array] = {}
        for column in every:
            try:
                found |= _read(table, [column])
            except InputError:  # text, which is no channel
                continue
        return found


def _read(table: Table, columns: Sequence[Column]) -> dict[int, Array]:
    """Samples of columns by place."""
    samples, _ = table.numbers(columns)
    return {c.index: y for c, y in zip(columns, samples, strict=True)}


def _joined(first: Seen, other: Seen) -> Seen:
    """A column of several files."""
    return replace(first, low=min(first.low, other.low), high=max(first.high, other.high))
