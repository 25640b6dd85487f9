"""Checked settings: a mapping read against a table of names, units, bounds and defaults.

Roads, duty programs and experiment files share it, so that a misspelt or missing key is one clear
line everywhere and the tables can be declared as ROS parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from er_models.errors import InputError

Array = NDArray[np.float64]
REQUIRED = object()
"""Default of a setting that has none."""


@dataclass(frozen=True, slots=True)
class Number:
    """A number with bounds: name, unit, default, low, high, meaning."""

    name: str
    unit: str
    default: object
    low: float
    high: float
    meaning: str

    def read(self, path: str | Path, key: str, found: object) -> float:
        """The value; `InputError` when it is no finite number within the bounds."""
        if isinstance(found, bool) or not isinstance(found, int | float | np.number):
            raise InputError(path, key, f"a number in {self.unit}", repr(found))
        value = float(found)
        if not math.isfinite(value) or not self.low <= value <= self.high:
            raise InputError(path, key, f"{self.low:g} to {self.high:g} {self.unit}", f"{value:g}")
        return value


@dataclass(frozen=True, slots=True)
class Text:
    """A text, one of `choices` where there are any."""

    name: str
    default: object
    meaning: str
    choices: tuple[str, ...] = ()

    def read(self, path: str | Path, key: str, found: object) -> str:
        """The text; `InputError` when it is none of the choices."""
        if not isinstance(found, str) or (self.choices and found not in self.choices):
            raise InputError(
                path,
                key,
                f"one of {', '.join(self.choices)}" if self.choices else "text",
                repr(found),
            )
        return found


@dataclass(frozen=True, slots=True)
class Series:
    """A list of numbers, each within the bounds; empty only where that is the default."""

    name: str
    unit: str
    default: object
    low: float
    high: float
    meaning: str

    def read(self, path: str | Path, key: str, found: object) -> Array:
        """The numbers (n,); `InputError` naming the first bad one."""
        if not isinstance(found, list | tuple | np.ndarray):
            raise InputError(path, key, f"a list of numbers in {self.unit}", repr(found))
        one = Number(self.name, self.unit, REQUIRED, self.low, self.high, self.meaning)
        return np.array([one.read(path, f"{key}[{i}]", v) for i, v in enumerate(found)], float)


@dataclass(frozen=True, slots=True)
class Parts:
    """A list of specs, each of one of `kinds` and with `more` settings beside its own."""

    name: str
    default: object
    kinds: Mapping[str, Kind]
    more: tuple[Setting, ...]
    meaning: str

    def read(self, path: str | Path, key: str, found: object) -> list[dict[str, Any]]:
        """The checked specs, as they were given; `InputError` naming the first bad setting."""
        if not isinstance(found, list | tuple):
            raise InputError(path, key, "a list of mappings with 'kind'", repr(found))
        specs = []
        for i, part in enumerate(found):
            where = f"{key}[{i}]"
            kind = choose(self.kinds, part, path, where)
            values = settings((*kind.settings, *self.more), part, path, where)
            specs.append({k: kind.name if k == "kind" else values[k] for k in part})
        return specs


Setting = Number | Text | Series | Parts


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of signal: its settings, and `make(settings, t, seed) -> values`; t [s] (n,).

    `make` gives the same value at the same time whatever other times are asked for, so that a node
    can ask in chunks.
    """

    name: str
    title: str
    settings: tuple[Setting, ...]
    make: Callable[[Mapping[str, Any], Array, int], Array]


def choose(kinds: Mapping[str, Kind], spec: object, path: str | Path, key: str = "") -> Kind:
    """The kind a spec names."""
    prefix = f"{key}." if key else ""
    if not isinstance(spec, Mapping):
        raise InputError(path, key, "a mapping with 'kind' and its settings", type(spec).__name__)
    kind = spec.get("kind")
    if kind not in kinds:
        near = get_close_matches(str(kind), kinds, n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        found = "nothing" if kind is None else f"'{kind}'{hint}"
        raise InputError(path, f"{prefix}kind", f"one of {', '.join(kinds)}", found)
    return kinds[str(kind)]


def settings(
    table: tuple[Setting, ...],
    spec: Mapping[Any, Any],
    path: str | Path,
    key: str = "",
    also: tuple[str, ...] = ("kind",),
) -> dict[str, Any]:
    """Every setting of a table, from the spec or by default; refuses unknown and missing keys."""
    prefix = f"{key}." if key else ""
    names = tuple(s.name for s in table)
    for name in spec:
        if name not in names and name not in also:
            near = get_close_matches(str(name), names, n=1)
            hint = f"an unknown key (did you mean {near[0]}?)" if near else "an unknown key"
            raise InputError(path, f"{prefix}{name}", f"one of {', '.join(also + names)}", hint)
    values: dict[str, Any] = {}
    for s in table:
        found = spec.get(s.name, s.default)
        if found is REQUIRED:
            raise InputError(path, f"{prefix}{s.name}", s.meaning, "nothing")
        values[s.name] = found if s.name not in spec else s.read(path, f"{prefix}{s.name}", found)
    return values
