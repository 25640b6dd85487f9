"""Spreadsheets (Excel, LibreOffice): of the sheet with most rows of numbers, what `csv` makes of its cells as text."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime, time, timedelta
from pathlib import Path
from typing import Any
from zipfile import ZipFile, is_zipfile

from er_common.extras import extra
from er_models.errors import ErError, InputError

from er_records.provenance import digest_bytes
from er_records.readers import csv
from er_records.readers.table import Table

Rows = list[list[Any]]
MIDNIGHT = datetime(1970, 1, 1)
FEW = 200
"""Rows of numbers from which on a spreadsheet in a folder is a measurement, and no list of runs."""
LARGEST = 1 << 31
"""Bytes that a book may unpack to."""
OPENED = "~$"
"""How the name begins of what Excel keeps beside a file that is open."""


def table(path: Path) -> Table:
    """The columns of the sheet with most rows of numbers.

    Raises:
        InputError: A damaged file, or one without numbers.
        ErError: The package that reads it is not installed.
    """
    sheets = _sheets(path)
    many = {name: _numbers(rows) for name, rows in sheets.items()}
    best = max(many, key=lambda name: many[name], default="")
    if not many.get(best):
        expected = "a sheet with rows of numbers"
        raise InputError(path, "", expected, f"none in {', '.join(sheets) or 'an empty book'}")
    others = [name for name in many if name != best and many[name] > 1]
    notes = [f"sheet '{best}' was read"] if len(sheets) > 1 else []
    notes += [f"sheets with numbers that were not: {', '.join(others)}"] if others else []
    lines = ["\t".join(map(_text, row)) for row in sheets[best]]
    filled = [line for line in lines if line.strip()]
    return csv.table_of(path, filled, digest_bytes(path.read_bytes()), notes)


def is_table(path: Path) -> bool:
    """Whether a spreadsheet in a folder is a measurement; one that cannot be read is taken for one, and told."""
    if path.name.startswith(OPENED):
        return False
    try:
        return max(map(_numbers, _sheets(path).values()), default=0) >= FEW
    except InputError:
        return True
    except ErError:  # without what reads it: a folder may hold lists of its runs
        return False


def _sheets(path: Path) -> Mapping[str, Rows]:
    """Cells of each sheet by its name."""
    with extra("er_records[sheets]", f"{path}: a spreadsheet"):
        from python_calamine import CalamineWorkbook
    unpacked = sum(part.file_size for part in ZipFile(path).infolist()) if is_zipfile(path) else 0
    if unpacked > LARGEST:
        raise InputError(
            path, "", f"a spreadsheet of at most {LARGEST >> 30} GB", f"{unpacked >> 30} GB"
        )
    try:
        book = CalamineWorkbook.from_path(str(path))
        return {name: book.get_sheet_by_name(name).to_python() for name in book.sheet_names}
    except Exception as error:  # damaged files raise whatever their bytes provoke
        why = (str(error).splitlines() or [type(error).__name__])[0]
        raise InputError(path, "", "a spreadsheet", why) from None


def _numbers(rows: Rows) -> int:
    """How many rows hold two numbers or more."""
    return sum(sum(isinstance(cell, float | int) for cell in row) > 1 for row in rows)


def _text(cell: Any) -> str:
    """A cell as a text table holds it."""
    if isinstance(cell, timedelta):
        cell = (MIDNIGHT + cell).time()
    if isinstance(cell, datetime):
        return cell.isoformat(sep=" ")
    if isinstance(cell, time):
        return cell.isoformat()
    return " ".join(str(cell).split())
