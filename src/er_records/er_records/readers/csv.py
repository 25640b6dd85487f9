"""CSV and other text tables: column names, perhaps a row of units, then numbers.

Delimiter comma, semicolon, tab or spaces. An empty cell or NaN is a missing sample. Lines starting with `#` above the
names are comments; one of them may carry the provenance that `er_records.write` stores. Lines of other widths above
the names are left out; so is what a row holds beyond the names. Unless the delimiter is a comma, numbers may have
decimal commas; the columns that are read say whether they do. A table without names has columns `column 1`,
`column 2`, ... for a mapping to name.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from er_models.arrow import samples
from er_models.errors import InputError

from er_records.provenance import METADATA_KEY, digest_bytes
from er_records.readers.columns import Column
from er_records.readers.names import Given, Names
from er_records.readers.table import Numbers, Table, record
from er_records.readers.units import looks_like_unit
from er_records.record import Array, Record, cure

SIGNS = {".": "decimal point", ",": "decimal comma"}
DELIMITERS = (",", ";", "\t")
MISSING = ("", "nan", "NaN", "NAN", "NA", "null")
OLD_WINDOWS = "äöüÄÖÜß°µ²³±·éèàç–"
"""What text of measuring programs that is not UTF-8 holds beside ASCII, in Windows-1252."""
MOST_ABOVE, SURELY = 60, 4
"""Lines among which the first numbers are looked for, and how many of them on end are samples, no more of a head."""

HALF_DAY = 43_200.0
"""A step back in a time of day beyond this is midnight [s]."""
_CLOCK = re.compile(
    r"(?:^|[ T])(\d{1,2}):(\d{2})(?::(\d{2}(?:[.,]\d+)?))?\s*(?:([AaPp])[Mm])?(?:Z|[+-]\d{2}:?\d{2})?$"
)
"""A time of day, behind a date or not: 23:59:59.995, 2022-04-29T12:11Z, 04/29/2022 12:11:14.596 PM."""
_UNITS = re.compile(r"\W*(?:[xy]_)?(?:units?|einheit)", re.IGNORECASE)
"""How a line begins that tells the units of the columns behind the first: Y_Unit_Label."""
_RULE = re.compile(r"[-=_+|;,\s]*(?:--|==|__)[-=_+|;,\s]*")
"""A line that is drawn below names."""


@dataclass(frozen=True)
class _Text:
    """A table as text: cells of names with units, rows of numbers; named: whether it has names."""

    header: tuple[str, ...]
    rows: list[str]
    delimiter: str
    named: bool = True


def read(path: Path, names: Given | Names | None = None) -> list[Record]:
    """The one record of a text table.

    Args:
        path: File; UTF-8, UTF-16 or Windows-1252 text.
        names: What the file's own columns are, by channel.

    Raises:
        InputError: Empty, not text, no names, wrong columns, a cell that is no number.
    """
    found = table(path)
    sources = names.sources if isinstance(names, Names) else names
    if found.header[:1] == ("column 1",) and not sources:
        row = found.notes[0]
        expected = "a header with column names such as t, deflection"
        raise InputError(path, "row 1", expected, row, cure(path))
    return [record(found, names)]


def table(path: Path) -> Table:
    """The columns of a text table.

    Raises:
        InputError: Empty, not text, no row of names; where it is read, a cell that is no number.
    """
    data = path.read_bytes()
    if not data.strip():
        raise InputError(path, "", "a CSV table with a header row", "an empty file")
    comments, lines, notes = _lines(path, data)
    text = _parted(lines)
    rows, complete = _without_cut_line(text, data)
    if not complete:
        notes.append("the last line is cut off and was dropped")
    said = next(iter(comments), "")
    return _table(
        path, replace(text, rows=rows), digest_bytes(data), notes, said, complete=complete
    )


def table_of(path: Path, lines: list[str], digest: str, notes: Sequence[str]) -> Table:
    """The columns of lines of text that some other file held, cells between tabs.

    Raises:
        InputError: Where it is read, a cell that is no number.
    """
    return _table(path, _parted(lines), digest, list(notes))


def _table(
    path: Path,
    text: _Text,
    digest: str,
    notes: list[str],
    said: str = "",
    *,
    complete: bool = True,
) -> Table:
    """A table as text, whose numbers are read where they are asked for; said: its provenance."""
    rows = text.rows

    def numbers(columns: Sequence[Column]) -> Numbers:
        clocks = [c for c in columns if _CLOCK.search(_cell(rows, text.delimiter, c.index))]
        plain = [c for c in columns if c not in clocks]
        decimal = _decimal(rows, text.delimiter, plain)
        how = ["numbers are written with a decimal comma"] * (decimal == "," and bool(plain))
        how += [f"{c.name} is a time of day, counted from the first row on" for c in clocks]
        found = {c.index: _clock(path, rows, text.delimiter, c) for c in clocks}
        read = _numbers(path, rows, text.delimiter, decimal, plain) if plain else []
        found |= {c.index: y for c, y in zip(plain, read, strict=True)}
        return [found[c.index] for c in columns], how

    if not text.named:
        notes.insert(0, f"no column names: {rows[0][:60]}")
    return Table(path, text.header, numbers, digest, complete, said, None, tuple(notes))


def _cell(rows: list[str], delimiter: str, index: int) -> str:
    """A cell of the first row; '' where there is none."""
    cells = rows[0].split(delimiter) if rows else []
    return cells[index].strip().strip('"') if index < len(cells) else ""


def _clock(path: Path, rows: list[str], delimiter: str, column: Column) -> Array:
    """Seconds (n,) since the first row, of a column of times of day; a day is added at midnight."""
    seconds = np.empty(len(rows))
    for k, row in enumerate(rows):
        found = _CLOCK.search(_cell([row], delimiter, column.index))
        if found is None:
            key = f"data row {k + 1}, column '{column.name}'"
            raise InputError(path, key, "a time of day such as 12:34:56.789", row[:60], cure(path))
        hours, minutes, rest, half = found.groups()
        day = 12.0 * (half is not None and half.lower() == "p") + float(hours) % (
            12 if half else 24
        )
        seconds[k] = 3600.0 * day + 60.0 * float(minutes) + float((rest or "0").replace(",", "."))
    back = np.cumsum(np.diff(seconds, prepend=seconds[:1]) < -HALF_DAY)
    return np.asarray(seconds + 2.0 * HALF_DAY * back - seconds[0])


def is_table(path: Path) -> bool:
    """Whether a text file is a table: most of its lines near the beginning are rows of two numbers or more."""
    with path.open("rb") as stream:
        data = stream.read(20_000)
    lines = [line for line in data.decode("latin-1").splitlines()[:-1] if line.strip()][-40:]
    cells = [re.split(r"[;\t]|,\s|\s+|,(?=\S*,)", line.strip()) for line in lines]
    good = sum(len(each) > 1 and _numeric(each) for each in cells)
    return len(lines) >= 10 and 2 * good > len(lines)


def _parted(lines: list[str]) -> _Text:
    """Lines of a table as names, units and rows, whatever stands above them."""
    body = lines[len(lines) // 2 :][:50]
    usual = {d: sorted(line.count(d) for line in body)[len(body) // 2] for d in DELIMITERS}
    delimiter = next((d for d in (";", "\t") if usual[d]), ",")
    if not usual[delimiter] and len(body[0].split()) > 1 and _numeric(body[0].split()):
        apart = [re.sub(r"(?<=[^\])\s])\s+(?=[\[(])", "", line) for line in lines]
        lines, delimiter = ["\t".join(line.split()) for line in apart], "\t"
        usual[delimiter] = lines[len(lines) // 2].count(delimiter)
    split = [line.split(delimiter) for line in lines[:MOST_ABOVE]]
    width = usual[delimiter] + 1
    wide = [len(cells) == width for cells in split]
    good = [wide[i] and (_numeric(c) or not _filled(c)) for i, c in enumerate(split)]
    first = next(
        (i for i, c in enumerate(split) if _numeric(c) and all(good[i : i + SURELY])), None
    )
    if first == 0:
        return _Text(tuple(f"column {i + 1}" for i in range(width)), lines, delimiter, named=False)
    if first is None or not wide[first - 1]:
        return _uneven(lines, split, delimiter, width)
    units, names = split[first - 1], split[first - 2] if first > 1 else []
    if len(names) == width and any(map(looks_like_unit, units)) and not _numeric(names):
        return _Text(tuple(map(_with_unit, names, units)), lines[first:], delimiter)
    told = next((c for i, c in enumerate(split[:first]) if wide[i] and _UNITS.match(c[0])), None)
    names = units if told is None else [units[0], *map(_with_unit, units[1:], told[1:])]
    return _Text(tuple(names), lines[first:], delimiter)


def _uneven(lines: list[str], split: list[list[str]], delimiter: str, width: int) -> _Text:
    """A table whose names are more or fewer than the usual row has cells.

    Beyond a row's cells stand events, which few rows have; a name is missing of row numbers, or where each row ends
    with a delimiter. A row that is shorter than the usual one stays so, and is told or dropped as any other.
    """
    first = next((i for i, c in enumerate(split) if len(c) >= width and _numeric(c)), 0)
    above = first - 1
    if first < 1 or len(split[above]) < max(width - 1, 2) or _numeric(split[above]):
        return _Text(tuple(split[0]), lines[1:], delimiter)
    names, rows = split[above], lines[first:]
    if len(names) < width and split[first][-1].strip():
        names = ["", *names]
    whole = max(len(names), width)
    cells = (row.split(delimiter)[:whole] for row in rows)
    even = [
        delimiter.join([*c, *[""] * (whole - len(c))] if len(c) >= width else c) for c in cells
    ]
    return _Text(tuple(names), even, delimiter)


def _with_unit(name: str, unit: str) -> str:
    """Header cell from the cells of a row of names and of a row of units."""
    name, bare = name.strip().strip('"'), unit.strip().strip('"').strip().strip("[]()").strip()
    return f"{name} [{bare}]" if bare and bare not in ("-", "1") else name


def _filled(cells: Sequence[str]) -> list[str]:
    """The cells that are no missing samples."""
    return [cell for cell in cells if cell.strip().strip('"') not in MISSING]


def _numeric(cells: Sequence[str]) -> bool:
    """Whether at least half of the cells that are filled are numbers, or times of day."""
    filled = _filled(cells)
    good = sum(_is_number(c, ".") or _is_number(c, ",") or bool(_CLOCK.search(c)) for c in filled)
    return bool(filled) and 2 * good >= len(filled)


def _lines(path: Path, data: bytes) -> tuple[list[str], list[str], list[str]]:
    """Provenance texts from the comments above the names, the lines of the table, and notes."""
    text, notes = _decoded(path, data)
    if "\0" in text:
        raise InputError(path, "", "text in UTF-8", "binary data")
    lines = text.splitlines()
    first = next(
        (i for i, line in enumerate(lines) if line.strip() and line[0] != "#"), len(lines)
    )
    marker = f"# {METADATA_KEY} "
    comments = [line[len(marker) :] for line in lines[:first] if line.startswith(marker)]
    rows = [line for line in lines[first:] if line.strip()]
    rows = [line for line in rows[:MOST_ABOVE] if not _RULE.fullmatch(line)] + rows[MOST_ABOVE:]
    if not rows:
        raise InputError(path, "", "a header row with column names", "only comments")
    return comments[:1], rows, notes


def _decoded(path: Path, data: bytes) -> tuple[str, list[str]]:
    """The text of a file, and a note where it is not in UTF-8."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", errors="replace"), ["read as UTF-16"]
    try:
        return data.decode("utf-8-sig"), []
    except UnicodeDecodeError as error:
        text = data.decode("cp1252", errors="replace")
        if set(filter(lambda c: not c.isascii(), text)) <= set(OLD_WINDOWS):
            return text, ["read as Windows-1252"]
        found = f"byte 0x{data[error.start]:02x} at position {error.start}"
        raise InputError(path, "", "text in UTF-8", found) from None


def _without_cut_line(text: _Text, data: bytes) -> tuple[list[str], bool]:
    """Rows below the names without a last one that a broken-off writer left unfinished."""
    rows, whole = text.rows, len(text.header) - 1
    ended = data.rstrip(b"\0").endswith((b"\n", b"\r"))
    if rows and not ended and rows[-1].count(text.delimiter) < whole:
        return rows[:-1], False
    return rows, True


def _decimal(rows: list[str], delimiter: str, columns: Sequence[Column]) -> str:
    """The decimal sign: unless cells are parted by it, that of most cells in the columns that are read."""
    if delimiter == "," or not any("," in row for row in rows):
        return "."
    count = dict.fromkeys(SIGNS, 0)
    for row in rows:
        cells = row.split(delimiter)
        read = delimiter.join(cells[c.index] for c in columns if c.index < len(cells))
        for sign in count:
            count[sign] += read.count(sign)
    return "," if count[","] > count["."] else "."


def _numbers(
    path: Path, rows: list[str], delimiter: str, decimal: str, columns: Sequence[Column]
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
    path: Path,
    rows: list[str],
    delimiter: str,
    decimal: str,
    columns: Sequence[Column],
    reason: str,
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
                expected = f"a number with {SIGNS[decimal]}"
                return InputError(path, key, expected, f"'{cell}'", cure(path))
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
