"""What a file's own columns are: `names.yaml` of a folder, `FILE.names.yaml` beside a file, or `names=` in Python.

One line a channel: its column, or a mapping that also scales, shifts and flips:

    t: Zeit
    duty: {from: "Strom [A]", full_scale: 1.6}
    damper_force: {from: Kraft, unit: kN, sign: -1, offset: 12.5}

A channel is sign * scale * column + offset, the column in `unit` (else in the unit that it states), the offset in SI.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from er_models.errors import InputError, UnknownName

from er_records.record import CHANNELS, unit_of

TIME = "t"
NAMES_SUFFIX = ".names.yaml"
"""Of the file beside a data file that says which of its columns is which channel."""
NAMES_FILE = "names.yaml"
"""The same for all data files of a folder and its folders."""
LEVELS_UP = 3
"""So many folders are looked into for a `names.yaml`: that of the data file, and those around it."""
KEYS = ("from", "unit", "scale", "full_scale", "sign", "offset", "rate", "value")

Given = Mapping[str, str | Mapping[str, Any]]
"""A mapping as a user writes it: a column's name, or a mapping of `KEYS`, by channel."""


@dataclass(frozen=True, slots=True)
class Source:
    """Where a channel comes from.

    column: name in the file, '' where `rate` or `value` makes it; unit: of the column, '' as the file states it;
    scale: factor to SI beside the unit; full_scale: what a duty of 1 is in the column; sign: 1 or -1; offset: added
    last [SI]; rate: of a time that the file does not hold [Hz]; value: of a channel that is constant [SI], one
    for each part of the record that a pause ends; signed: whether somebody said the sign.
    """

    column: str = ""
    unit: str = ""
    scale: float | None = None
    full_scale: float | None = None
    sign: float = 1.0
    offset: float = 0.0
    rate: float | None = None
    value: tuple[float, ...] | None = None
    signed: bool = field(default=False, compare=False)


NOTHING = Source()
"""Of a column that nobody has said anything of."""


@dataclass(frozen=True)
class Names:
    """Sources by channel; where: the file that says so; lenient: a column that a file lacks is left out."""

    sources: Mapping[str, Source]
    where: str = ""
    lenient: bool = False


NONE = Names({})


def parsed(given: Given | Names | None, where: str = "names", *, lenient: bool = False) -> Names:
    """A mapping as a user wrote it.

    Raises:
        InputError: Neither a name nor a mapping, an unknown key, no number where one belongs.
        UnknownName: A channel that there is none of.
    """
    if isinstance(given, Names):
        return given
    sources = {}
    for channel, entry in (given or {}).items():
        if channel != TIME and unit_of(str(channel)) is None:
            raise UnknownName("channel", str(channel), (TIME, *CHANNELS))
        entry = {"from": entry} if isinstance(entry, str) else entry
        if not isinstance(entry, Mapping):
            raise InputError(where, channel, "a column's name, or {from: ...}", repr(entry))
        sources[str(channel)] = _source(where, str(channel), entry)
    return Names(sources, where, lenient)


def _source(where: str, channel: str, entry: Mapping[str, Any]) -> Source:
    """One line of a mapping."""
    for key in entry:
        if key not in KEYS:
            raise InputError(
                where, f"{channel}.{key}", f"one of {', '.join(KEYS)}", "an unknown key"
            )
    numbers = {
        key: _number(where, f"{channel}.{key}", entry[key])
        for key in ("scale", "full_scale", "sign", "offset", "rate") if key in entry
    }  # fmt: skip
    for key in ("from", "unit"):
        if not isinstance(entry.get(key, ""), str):
            raise InputError(where, f"{channel}.{key}", "text", repr(entry[key]))
    made = "rate" if channel == TIME else "value"
    if not entry.get("from") and made not in entry:
        raise InputError(where, channel, f"'from' and a column's name, or '{made}'", dict(entry))
    if abs(numbers.get("sign", 1.0)) != 1.0:
        raise InputError(where, f"{channel}.sign", "1 or -1", entry["sign"])
    for key in ("scale", "full_scale", "rate"):
        if numbers.get(key, 1.0) <= 0.0:
            raise InputError(where, f"{channel}.{key}", "a number above 0", entry[key])
    if "full_scale" in numbers and channel != "duty":
        raise InputError(where, f"{channel}.full_scale", "the full scale of a duty alone", channel)
    value = _values(where, f"{channel}.value", entry["value"]) if "value" in entry else None
    return Source(
        entry.get("from", ""),
        entry.get("unit", ""),
        **numbers,
        value=value,
        signed="sign" in numbers,
    )


def _values(where: str, key: str, found: Any) -> tuple[float, ...]:
    """A constant, or one for each part of a record."""
    each = found if isinstance(found, list | tuple) and found else [found]
    return tuple(_number(where, key, x) for x in each)


def _number(where: str, key: str, found: Any) -> float:
    """A finite number."""
    if isinstance(found, bool) or not isinstance(found, int | float) or not math.isfinite(found):
        raise InputError(where, key, "a number", repr(found))
    return float(found)


def read_names(path: Path, *, lenient: bool = False) -> Names:
    """The mapping of a YAML file."""
    try:
        names = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise InputError(path, "", "YAML", " ".join(str(error).split())) from None
    if not isinstance(names, dict):
        raise InputError(path, "", "lines 'deflection: name in the file'", type(names).__name__)
    return parsed(names, str(path), lenient=lenient)


def names_files(path: Path) -> list[Path]:
    """Where the names of a data file or recording may stand, nearest first."""
    folder = path.absolute().parent
    around = [folder, *folder.parents][:LEVELS_UP]
    inside = [path / NAMES_FILE] if path.is_dir() else []
    beside = path.with_name(path.name + NAMES_SUFFIX)
    return [beside, *inside, *(f / NAMES_FILE for f in around)]


def names_file(path: Path) -> Path | None:
    """The file that says what the columns of a data file are; None where there is none."""
    return next((f for f in names_files(path) if f.is_file()), None)


def names_of(path: Path) -> Names:
    """What the columns of a data file are, as the file nearest to it says."""
    found = names_file(path)
    if found is None:
        return NONE
    return read_names(found, lenient=found.name == NAMES_FILE)
