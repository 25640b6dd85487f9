"""CSV: a header with the contract's names, then numbers; delimiter comma, semicolon or tab.

An empty cell or NaN is a missing sample. Lines starting with `#` above the header are comments;
one of them may carry the provenance that `er_records.write` stores. With semicolons, numbers may
have decimal commas; the columns that are read say whether they do.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from er_models.arrow import samples
from er_models.errors import InputError

from er_records.provenance import METADATA_KEY, digest_bytes, restore
from er_records.readers.columns import TIME, Column, resolve, to_si
from er_records.record import Array, Record

SIGNS = {".": "decimal point", ",": "decimal comma"}
DELIMITERS = (",", ";", "\t")
MISSING = ("", "nan", "NaN", "NAN", "NA", "null")


def read(path: Path, names: Mapping[str, str] | None = None) -> list[Record]:
    """The one record of a CSV file.

    Args:
        path: File; UTF-8 text.
        names: Contract name to column name, for files with other headers.

    Raises:
        InputError: Empty, not text, no header, wrong columns, a cell that is no number.
    """
    data = path.read_bytes()
    if not data.strip():
        raise InputError(path, "", "a CSV table with a header row", "an empty file")
    comments, lines = _lines(path, data)
    delimiter = max(DELIMITERS, key=lines[0].count)
    header = lines[0].split(delimiter)
    if all(_is_number(cell, ".") for cell in header):
        raise InputError(
            path, "row 1", "a header with column names such as t, deflection", lines[0][:60]
        )
    columns, notes = resolve(path, header, names)
    rows, complete = _without_cut_line(lines, delimiter, data)
    decimal = _decimal(rows, delimiter, columns)
    if decimal == ",":
        notes.append("numbers are written with a decimal comma")
    if not complete:
        notes.append("the last line is cut off and was dropped")
    samples = {TIME: np.empty(0)}
    for column, raw in zip(
        columns, _numbers(path, rows, delimiter, decimal, columns), strict=True
    ):
        samples[column.name], how = to_si(column, raw)
        notes += how
    t = samples.pop(TIME)
    record = Record(path.stem, t, samples, tuple(notes), complete, str(path), digest_bytes(data))
    return [restore(record, text, path) for text in comments] or [record]


def _lines(path: Path, data: bytes) -> tuple[list[str], list[str]]:
    """Provenance texts from the comments above the header, and the lines of the table."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        found = f"byte 0x{data[error.start]:02x} at position {error.start}"
        raise InputError(path, "", "text in UTF-8", found) from None
    if "\0" in text:
        raise InputError(path, "", "text in UTF-8", "binary data")
    lines = text.splitlines()
    first = next(
        (i for i, line in enumerate(lines) if line.strip() and line[0] != "#"), len(lines)
    )
    marker = f"# {METADATA_KEY} "
    comments = [line[len(marker) :] for line in lines[:first] if line.startswith(marker)]
    table = [line for line in lines[first:] if line.strip()]
    if not table:
        raise InputError(path, "", "a header row with column names", "only comments")
    return comments[:1], table


def _without_cut_line(lines: list[str], delimiter: str, data: bytes) -> tuple[list[str], bool]:
    """Rows below the header without a last one that a broken-off writer left unfinished."""
    rows = lines[1:]
    whole = lines[0].count(delimiter)
    if rows and not data.endswith((b"\n", b"\r")) and rows[-1].count(delimiter) < whole:
        return rows[:-1], False
    return rows, True


def _decimal(rows: list[str], delimiter: str, columns: list[Column]) -> str:
    """The decimal sign: with semicolons, that of most cells in the columns that are read."""
    if delimiter != ";" or not any("," in row for row in rows):
        return "."
    count = dict.fromkeys(SIGNS, 0)
    for row in rows:
        cells = row.split(delimiter)
        read = delimiter.join(cells[c.index] for c in columns if c.index < len(cells))
        for sign in count:
            count[sign] += read.count(sign)
    return "," if count[","] > count["."] else "."


def _numbers(
    path: Path, rows: list[str], delimiter: str, decimal: str, columns: list[Column]
) -> list[Array]:
    """Samples of each column (N,), NaN where missing."""
    import pyarrow as pa
    import pyarrow.csv as pacsv

    if not rows:
        return [np.empty(0) for _ in columns]
    width = rows[0].count(delimiter) + 1
    keys = [str(i) for i in range(width)]
    wanted = [str(column.index) for column in columns]
    try:
        table = pacsv.read_csv(
            pa.BufferReader("\n".join(rows).encode()),
            read_options=pacsv.ReadOptions(column_names=keys, use_threads=False),
            parse_options=pacsv.ParseOptions(delimiter=delimiter),
            convert_options=pacsv.ConvertOptions(
                column_types={key: pa.float64() for key in wanted},
                include_columns=wanted,
                null_values=list(MISSING),
                decimal_point=decimal,
            ),
        )
    except (pa.ArrowInvalid, pa.ArrowKeyError) as error:
        raise _explain(path, rows, delimiter, decimal, columns, str(error)) from None
    return [samples(table.column(key)) for key in wanted]


def _explain(
    path: Path, rows: list[str], delimiter: str, decimal: str, columns: list[Column], reason: str
) -> InputError:
    """The first cell that cannot be read, in the terms of the person who wrote the file."""
    width = max(len(rows[0].split(delimiter)), max(column.index for column in columns) + 1)
    for number, row in enumerate(rows, start=1):
        cells = row.split(delimiter)
        if len(cells) != width:
            return InputError(path, f"data row {number}", f"{width} cells", len(cells))
        for column in columns:
            cell = cells[column.index].strip()
            if cell not in MISSING and not _is_number(cell, decimal):
                key = f"data row {number}, column '{column.name}'"
                return InputError(path, key, f"a number with {SIGNS[decimal]}", f"'{cell}'")
    return InputError(path, "", "a CSV table", reason.splitlines()[0])


def _is_number(cell: str, decimal: str) -> bool:
    """Whether a cell reads as a number."""
    if decimal == "," and "." in cell:
        return False
    try:
        float(cell.strip().strip('"').replace(decimal, "."))
    except ValueError:
        return False
    return True
