"""Column headers to channels: contract names, stated units, the nearest name for a wrong one."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from er_models.constants import g
from er_models.errors import InputError, UnknownName

from er_records.record import CHANNELS, Array, unit_of

TIME = "t"
NAMES_SUFFIX = ".names.yaml"
"""Of the file beside a data file that says which of its columns is which channel."""

UNITS: dict[str, dict[str, float]] = {
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254},
    "m/s": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "in/s": 0.0254},
    "1": {"1": 1.0, "-": 1.0, "%": 1e-2},
    "N": {"N": 1.0, "kN": 1e3, "kgf": g, "lbf": 4.4482216152605},
    "m/s2": {"m/s2": 1.0, "m/s^2": 1.0, "m/s²": 1.0, "mm/s2": 1e-3, "g": g},
    "K": {"K": 1.0, "degC": 1.0, "°C": 1.0},
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "bar": 1e5},
}
"""SI unit to the accepted ways of stating it and their factors (exact by definition)."""

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

_HEADER = re.compile(r"^(?P<name>.*?)\s*(?:[\[(](?P<unit>[^\])]*)[\])])?$")


@dataclass(frozen=True, slots=True)
class Column:
    """A column to read: place in the file, channel, factor to SI, unit as stated or ''."""

    index: int
    name: str
    factor: float
    stated: str


def split_header(cell: str) -> tuple[str, str]:
    """Name and stated unit of a header cell such as `deflection [mm]`; unit '' when absent."""
    found = _HEADER.match(cell.strip().strip('"').strip())
    if found is None:
        return cell.strip(), ""
    return found["name"].strip(), (found["unit"] or "").strip()


def nearest(name: str) -> str | None:
    """The contract's name that `name` probably means; None if none is near."""
    lower = name.lower()
    if lower in SYNONYMS:
        return SYNONYMS[lower]
    near = get_close_matches(lower, (TIME, *CHANNELS), n=1, cutoff=0.75)
    return near[0] if near else None


def factor_to_si(path: Path, name: str, unit: str) -> float:
    """Factor from a stated unit to SI; 1 when none is stated; `InputError` for an unknown one."""
    known = UNITS["s" if name == TIME else unit_of(name) or "1"]
    if unit and unit not in known:
        raise InputError(path, f"column '{name}'", f"a unit among {', '.join(known)}", unit)
    return known[unit] if unit else 1.0


def resolve(
    path: Path,
    header: Sequence[str],
    names: Mapping[str, str] | None = None,
    *,
    needs_time: bool = True,
) -> tuple[list[Column], list[str]]:
    """Which columns of a file to read.

    Args:
        path: File, for messages.
        header: Header cells, each a name with an optional unit in brackets.
        names: Contract name to name in this file, for files with other names.
        needs_time: Whether a column `t` must be there.

    Returns:
        Columns to read, and notes on those left out.

    Raises:
        InputError: No `t`, no channel, a misspelt or repeated column, an unknown unit.
        UnknownName: A key of `names` that is no channel.
    """
    cells = _renamed(path, [split_header(cell) for cell in header], names or {})
    columns = [
        Column(index, name, factor_to_si(path, name, unit), unit)
        for index, (name, unit) in enumerate(cells)
        if name == TIME or (unit_of(name) is not None and with_unit(name) is None)
    ]
    ignored = _ignored(path, cells, {column.name for column in columns})
    _check(path, columns, cells, needs_time=needs_time)
    return columns, [f"column '{name}' is not a channel and was left out" for name in ignored]


def _ignored(path: Path, cells: list[tuple[str, str]], read: set[str]) -> list[str]:
    """Names of columns that are left out; `InputError` for one that a channel is missing from."""
    others = [name for name, _ in cells if name and name not in read]
    for name in others:
        stated = with_unit(name)
        meant = stated[0] if stated else nearest(name)
        if meant is not None and meant not in read:
            written = f"{meant} [{stated[1]}]" if stated else meant
            found = f"'{name}' (did you mean '{written}'?)"
            raise InputError(path, "columns", f"'{meant}'", found)
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
    """Samples in SI units, and the note on it; degC becomes a difference to 0 degC, the same in all files."""
    if column.stated in ("degC", "°C"):
        return samples, ["temperature is the difference to 0 degC"]
    if column.factor == 1.0:
        return samples, []
    si = "s" if column.name == TIME else unit_of(column.name)
    return samples * column.factor, [f"{column.name} converted from {column.stated} to {si}"]


def _renamed(
    path: Path, cells: list[tuple[str, str]], names: Mapping[str, str]
) -> list[tuple[str, str]]:
    """Header cells with the file's own names replaced by the contract's."""
    renamed = list(cells)
    for channel, own in names.items():
        if channel != TIME and unit_of(channel) is None:
            raise UnknownName("channel", channel, (TIME, *CHANNELS))
        own_name, own_unit = split_header(own)
        hits = [i for i, (name, _) in enumerate(cells) if name in (own, own_name)]
        if not hits:
            found = ", ".join(name for name, _ in cells)
            raise InputError(path, f"column for '{channel}'", f"'{own}'", found)
        renamed[hits[0]] = (channel, own_unit or cells[hits[0]][1])
    return renamed


def _check(
    path: Path, columns: list[Column], cells: list[tuple[str, str]], *, needs_time: bool
) -> None:
    """Refuse a table without time, without any channel of the contract, or with one twice."""
    found = ", ".join(name for name, _ in cells[:12]) or "nothing"
    names = {column.name for column in columns}
    for name in names:
        number = sum(column.name == name for column in columns)
        if number > 1:
            raise InputError(path, f"column '{name}'", "one column of that name", number)
    if needs_time and TIME not in names:
        raise InputError(path, "columns", "a column 't' [s]", found + _hint(path))
    if not names & set(CHANNELS):
        expected = f"at least one of {', '.join(CHANNELS)}"
        raise InputError(path, "columns", expected, found + _hint(path))


def _hint(path: Path) -> str:
    """How a file with names of its own is read, where nothing says so yet."""
    beside = path.name + NAMES_SUFFIX
    return (
        "" if path.with_name(beside).exists() else f" (names of your own: {beside}, docs/data.md)"
    )
