"""Column headers to channels: contract names, names of one's own, stated units, the nearest name for a wrong one."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import numpy as np
from er_models.errors import InputError
from numpy.typing import NDArray

from er_records.readers.names import NOTHING, TIME, Given, Names, Source, parsed
from er_records.readers.units import UNITS, ZERO, known_unit, quantities
from er_records.record import CHANNELS, Array, cure, unit_of
from er_records.timing import HOLE

SYNONYMS: dict[str, str] = {
    "time": TIME, "timestamp": TIME, "seconds": TIME,
    "x": "deflection", "displacement": "deflection", "disp": "deflection", "stroke": "deflection",
    "position": "deflection", "travel": "deflection",
    "v": "deflection_velocity", "velocity": "deflection_velocity", "vel": "deflection_velocity",
    "speed": "deflection_velocity",
    "f": "damper_force", "force": "damper_force", "load": "damper_force",
    "u": "duty", "pwm": "duty", "command": "duty", "current": "duty", "voltage": "duty",
    "zr": "road", "z_r": "road", "acc_s": "sprung_acceleration", "acc_u": "unsprung_acceleration",
    "temp": "temperature",
}  # fmt: skip
"""Frequent names for a channel: only used to say which name is meant, never to guess."""

_PLACE = re.compile(r"[^\s\[(][\[(]\d+[\])]\s*$")
"""What counts columns of a matrix or numbers of a message, and is no unit: `data(2)`, `position[1]`."""
BEYOND = 0.05
"""Share of a full scale by which a measured current or voltage may lie outside of it and counts as its end."""
LEFT_OUT = "is not a channel and was left out"
_HEADER = re.compile(r"^(?P<name>.*?)\s*(?:[\[(](?P<unit>[^\])]*)[\])])?$")
_QUANTITY = re.compile(
    r"^(?P<name>[^/]*[^/\s])(?:\s+(?:/|in)\s+(?P<unit>\S.*)|/(?P<close>N|%|\S.+))$"
)
"""How DIN 1313 writes a quantity over its unit, `Kraft / kN` or `Kraft/kN`, and `Kraft in kN`."""


@dataclass(frozen=True, slots=True)
class Column:
    """A column to read: place in the file, channel, unit as stated or ''; SI is factor * stored + shift.

    source: what the user said of it; index is -1 where `source` makes it without a column.
    """

    index: int
    name: str
    factor: float
    stated: str
    shift: float = 0.0
    source: Source = NOTHING


def split_header(cell: str) -> tuple[str, str]:
    """Name and stated unit of a header cell such as `deflection [mm]` or `Weg / mm`; unit '' when absent."""
    bare = cell.strip().strip('"').strip()
    found, over = _HEADER.match(bare), _QUANTITY.match(bare)
    bracketed = found is not None and found["unit"]
    if over is not None and not bracketed and quantities(unit := over["unit"] or over["close"]):
        return over["name"].strip(), unit.strip()
    if found is None or _PLACE.search(cell):
        return cell.strip(), ""
    return found["name"].strip(), (found["unit"] or "").strip()


def nearest(name: str) -> str | None:
    """The contract's name that `name` probably means; None if none is near."""
    lower = name.lower()
    if lower in SYNONYMS:
        return SYNONYMS[lower]
    near = get_close_matches(lower, (TIME, *CHANNELS), n=1, cutoff=0.75)
    return near[0] if near else None


def column_of(path: Path, index: int, name: str, unit: str, source: Source) -> Column:
    """A column with what makes it SI; `InputError` for a unit that is none of the channel's."""
    si = "s" if name == TIME else unit_of(name) or "1"
    known = known_unit(si, unit) if unit else None
    scaled = source.scale is not None or source.full_scale is not None
    if unit and known is None and not scaled:
        raise InputError(
            path, f"column '{name}'", f"a unit among {', '.join(UNITS[si])}", unit, cure(path)
        )
    factor = UNITS[si][known] if known and source.full_scale is None else 1.0
    factor *= source.sign * (source.scale or 1.0) / (source.full_scale or 1.0)
    shift = source.offset - factor * ZERO.get(known or "", 0.0)
    return Column(index, name, factor, known or unit, shift, source)


def resolve(
    path: Path,
    header: Sequence[str],
    names: Given | Names | None = None,
    *,
    needs_time: bool = True,
) -> tuple[list[Column], list[str]]:
    """Which columns of a file to read.

    Args:
        path: File, for messages.
        header: Header cells, each a name with an optional unit in brackets.
        names: What the file's own columns are, by channel.
        needs_time: Whether a column `t` must be there.

    Returns:
        Columns to read, and notes on those left out.

    Raises:
        InputError: No `t`, no channel, a misspelt or repeated column, an unknown unit.
        UnknownName: A key of `names` that is no channel.
    """
    own = parsed(names)
    cells, sources, notes = _renamed(path, header, own)
    columns = [
        column_of(path, index, name, unit, sources.get(index, NOTHING))
        for index, (name, unit) in enumerate(cells)
        if name == TIME or (unit_of(name) is not None and with_unit(name) is None)
    ]
    columns += [_made(name, s) for name, s in own.sources.items() if not s.column]
    ignored = _ignored(path, cells, {column.name for column in columns}, own)
    _check(path, columns, cells, needs_time=needs_time)
    notes += [f"column '{name}' {LEFT_OUT}" for name in ignored]
    return columns, notes


def _made(name: str, source: Source) -> Column:
    """A channel that no column holds."""
    return Column(-1, name, 1.0, "", source=source)


def made(path: Path | str, columns: Sequence[Column], n: int, t: Array | None) -> dict[str, Array]:
    """Samples (n,) of the channels that no column holds [SI]: equal steps of time, constants, or a constant a part.

    t: times (n,) [s] of the columns; None where a rate makes them.

    Raises:
        InputError: Fewer pauses in time than constants need.
    """
    found: dict[str, Array] = {}
    for column in sorted(columns, key=lambda c: c.name != TIME):
        if column.name == TIME:
            t = found[TIME] = np.arange(n) / (column.source.rate or 1.0)
        else:
            values = column.source.value or (0.0,)
            part = (
                np.zeros(n, dtype=np.int64)
                if len(values) == 1 or t is None
                else _parts(path, column, t)
            )
            found[column.name] = np.asarray(values)[part]
    return found


def _parts(path: Path | str, column: Column, t: Array) -> NDArray[np.int64]:
    """Which of a channel's constants counts for each row (n,): the longest pauses part them."""
    values = column.source.value or ()
    steps = np.diff(t)
    pauses = np.flatnonzero(steps > HOLE * np.median(steps))
    if pauses.size < len(values) - 1:
        most = pauses.size + 1
        expected = f"{most} value{'s' * (most > 1)}, one for each part between pauses"
        raise InputError(path, f"{column.name}.value", expected, len(values))
    longest = np.sort(pauses[np.argsort(-steps[pauses], kind="stable")[: len(values) - 1]])
    return np.asarray(np.searchsorted(longest, np.arange(t.size)))


def _ignored(path: Path, cells: list[tuple[str, str]], read: set[str], own: Names) -> list[str]:
    """Names of columns that are left out; `InputError` for one that a channel is missing from.

    Where the user has said what the columns are, the rest are left out without a question.
    """
    others = [name for name, _ in cells if name and name not in read]
    for name in () if own.sources else others:
        stated = with_unit(name)
        meant = stated[0] if stated else nearest(name)
        if meant is not None and meant not in read:
            written = f"{meant} [{stated[1]}]" if stated else meant
            found = f"'{name}' (did you mean '{written}'?)"
            raise InputError(path, "columns", f"'{meant}'", found, cure(path))
    return others


def with_unit(name: str) -> tuple[str, str] | None:
    """Channel and unit that a name such as `deflection_mm` or `force_kN` means; None for any other."""
    head, mark, tail = name.replace("-", "_").rpartition("_")
    channel = head.lower() if head.lower() in (TIME, *CHANNELS) else SYNONYMS.get(head.lower())
    if not mark or channel is None:
        return None
    units = {unit.lower(): unit for unit in UNITS["s" if channel == TIME else CHANNELS[channel]]}
    return (channel, units[tail.lower()]) if tail.lower() in units else None


def to_si(column: Column, samples: Array) -> tuple[Array, list[str]]:
    """Samples in SI units, and notes on what was done; a temperature becomes the difference to 0 degC."""
    si, source = "s" if column.name == TIME else unit_of(column.name), column.source
    notes = []
    if column.stated in ZERO:
        notes.append("temperature is the difference to 0 degC")
    if source.full_scale is not None:
        notes.append(
            f"{column.name} is '{source.column}' over its full scale: {full_scale(column)}"
        )
    elif column.stated not in (*ZERO, "", si) and source.scale is None:
        notes.append(f"{column.name} converted from {column.stated} to {si}")
    if source.scale is not None:
        notes.append(f"{column.name} is '{source.column}' times {abs(column.factor):g} {si}")
    if source.sign < 0.0:
        notes.append(f"{column.name} is turned round: sign -1")
    if source.offset:
        notes.append(f"{column.name} is shifted by {source.offset:g} {si}")
    if column.factor == 1.0 and column.shift == 0.0 and source.full_scale is None:
        return samples, notes
    found = samples * column.factor + column.shift
    if (
        source.full_scale is not None
    ):  # a measured current is noisy about nothing and about its full scale
        near = (found > -BEYOND) & (found < 1.0 + BEYOND)
        found = np.where(near, np.clip(found, 0.0, 1.0), found)
    return found, notes


def full_scale(column: Column) -> str:
    """What a duty of 1 is: `1 = 1.6 A`."""
    return f"1 = {column.source.full_scale:g} {column.stated}".rstrip()


def scales_of(columns: Sequence[Column]) -> dict[str, str]:
    """What 1 of each scaled channel means, for the record."""
    return {c.name: full_scale(c) for c in columns if c.source.full_scale is not None}


def _renamed(
    path: Path, header: Sequence[str], own: Names
) -> tuple[list[tuple[str, str]], dict[int, Source], list[str]]:
    """Names and units of header cells with the file's own names replaced by the contract's.

    Returns also what was said of each by its place, and a note for each column that one file of a folder lacks.
    """
    cells = [split_header(cell) for cell in header]
    places = {c: _place(header, cells, s.column) for c, s in own.sources.items() if s.column}
    missing = [c for c, index in places.items() if index is None]
    notes = []
    for channel in missing:
        column = own.sources[channel].column
        if not own.lenient:
            found = ", ".join(name for name, _ in cells)
            raise InputError(path, f"column for '{channel}'", f"'{column}'", found, cure(path))
        if channel not in {name for name, _ in cells}:
            notes.append(f"no column '{column}', which {own.where} takes for {channel}")
    # what the user says goes before a column that happens to have the channel's name
    renamed = [
        (f"{name} of the file" if name in own.sources.keys() - {*missing} else name, unit)
        for name, unit in cells
    ]
    sources: dict[int, Source] = {}
    for channel, index in places.items():
        if index in sources:
            raise InputError(
                path, f"column '{cells[index][0]}'", "one channel", channel, cure(path)
            )
        if index is not None:
            source = own.sources[channel]
            unit = source.unit or split_header(source.column)[1] or cells[index][1]
            renamed[index], sources[index] = (channel, unit), source
    return renamed, sources, notes


def _place(header: Sequence[str], cells: list[tuple[str, str]], column: str) -> int | None:
    """Place of a column by its whole header, else by its name; None where there is none."""
    if not column:
        return None
    bare = split_header(column)[0]
    whole = [
        i for i, cell in enumerate(header) if cell.strip().strip('"').strip() == column.strip()
    ]
    named = [i for i, (name, _) in enumerate(cells) if name in (column, bare)]
    return next(iter([*whole, *named]), None)


def _check(
    path: Path, columns: list[Column], cells: list[tuple[str, str]], *, needs_time: bool
) -> None:
    """Refuse a table without time, without any channel of the contract, or with one twice."""
    found = ", ".join(name for name, _ in cells[:12]) or "nothing"
    names = {column.name for column in columns}
    for name in names:
        number = sum(column.name == name for column in columns)
        if number > 1:
            raise InputError(
                path, f"column '{name}'", "one column of that name", number, cure(path)
            )
    if needs_time and TIME not in names:
        raise InputError(path, "columns", "a column 't' [s]", found, cure(path))
    if not names & set(CHANNELS):
        expected = f"at least one of {', '.join(CHANNELS)}"
        raise InputError(path, "columns", expected, found, cure(path))
