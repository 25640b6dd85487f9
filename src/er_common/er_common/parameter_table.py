"""A node's parameters as one frozen dataclass: type, default, bounds, unit, meaning. No ROS here.

Example::

    @dataclass(frozen=True, kw_only=True)
    class PlantParameters:
        rate: float = param(200.0, unit="Hz", low=1.0, high=2000.0, text="steps per second")
        model: str = param(REQUIRED, text="model file")
        seed: int = param(0, low=0, text="seed of the sensor noise")
        gains: tuple[float, ...] = param((1.0, 2.0), unit="N s/m", length=2, text="one per vertex")
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import Field, dataclass, field, fields
from difflib import get_close_matches
from numbers import Integral, Real
from typing import Any, Final, TypeVar, get_type_hints

from er_models.errors import InputError

KINDS: Final = {
    bool: "true or false",
    int: "an integer",
    float: "a number",
    str: "a text",
    tuple[float, ...]: "a list of numbers",
    tuple[int, ...]: "a list of integers",
    tuple[str, ...]: "a list of texts",
}
P = TypeVar("P")


class _Required:
    """Marks a parameter without default; prints as the word."""

    def __repr__(self) -> str:
        return "required"


REQUIRED: Final = _Required()


@dataclass(frozen=True, slots=True)
class Spec:
    """One parameter: everything that is known about it, in one place.

    Attributes:
        name: name in ROS, dots allowed.
        kind: one of ``KINDS``.
        low, high: bounds, included, of each number, in `unit`.
        choices: allowed texts; empty when any is.
        length: number of entries of a list; None when free.
        dynamic: whether it may change while the node acts, from one sample to the next.
        fixed: whether it cannot even change while the node is unconfigured.
    """

    attribute: str
    name: str
    kind: Any
    default: Any
    unit: str
    text: str
    low: float
    high: float
    choices: tuple[str, ...]
    length: int | None
    dynamic: bool
    fixed: bool


def param(
    default: Any,
    *,
    text: str,
    unit: str = "-",
    low: float = -math.inf,
    high: float = math.inf,
    choices: tuple[str, ...] = (),
    length: int | None = None,
    dynamic: bool = False,
    fixed: bool = False,
    name: str = "",
) -> Any:
    """Field of a parameter dataclass; the default is REQUIRED where there is no safe one."""
    meta = dict(text=text, unit=unit, low=low, high=high, choices=choices, length=length)
    return field(
        default=default, metadata={"param": meta | dict(dynamic=dynamic, fixed=fixed, name=name)}
    )


def tuning(default: Any, **given: Any) -> Any:
    """Field as `param` makes it, of a value that may change while the node acts."""
    return param(default, dynamic=True, **given)


def specs(table: type[Any]) -> tuple[Spec, ...]:
    """Specifications of a parameter dataclass, in order of declaration.

    Raises:
        TypeError: a field is not made with `param`, or its type is not one of ``KINDS``.
    """
    hints = get_type_hints(table)
    return tuple(_spec(table, item, hints[item.name]) for item in fields(table))


def _spec(table: type[Any], item: Field[Any], kind: Any) -> Spec:
    if "param" not in item.metadata:
        raise TypeError(f"{table.__name__}.{item.name} is not declared with param()")
    if kind not in KINDS:
        raise TypeError(f"{table.__name__}.{item.name}: {kind} is not a parameter type")
    meta = dict(item.metadata["param"])
    name = meta.pop("name") or item.name
    return Spec(attribute=item.name, name=name, kind=kind, default=item.default, **meta)


def expectation(spec: Spec) -> str:
    """What a value must be, in words, for messages and help."""
    words = KINDS[spec.kind]
    if spec.length is not None:
        words = words.replace("a list of", f"a list of {spec.length}")
    if spec.choices:
        return f"one of {', '.join(spec.choices)}"
    low, high = spec.low, spec.high
    if math.isfinite(low) and math.isfinite(high):
        words += f" in {low:g}..{high:g}"
    elif math.isfinite(low):
        words += f" >= {low:g}"
    elif math.isfinite(high):
        words += f" <= {high:g}"
    return words if spec.unit == "-" else f"{words} [{spec.unit}]"


def check(spec: Spec, value: Any, where: str) -> Any:
    """The value in its declared type; an integer becomes a number where a number is declared.

    Raises:
        InputError: wrong type, not finite, out of bounds, wrong length or not one of the choices.
    """
    if spec.kind in (bool, int, float, str):
        good = _scalar(spec.kind, value)
        entries: tuple[Any, ...] = (good,)
    else:
        inner = spec.kind.__args__[0]
        listed = _as_list(value)
        good = entries = () if listed is None else tuple(_scalar(inner, v) for v in listed)
        if listed is None or (spec.length is not None and len(listed) != spec.length):
            raise InputError(where, spec.name, expectation(spec), _shown(value))
    if any(entry is None or not _allowed(spec, entry) for entry in entries):
        raise InputError(where, spec.name, expectation(spec), _shown(value))
    return good


def build(table: type[P], given: Mapping[str, Any], origins: Mapping[str, str]) -> P:
    """Frozen parameters from given values and the table's defaults.

    Args:
        table: parameter dataclass.
        given: ROS parameter name to value.
        origins: ROS parameter name to where it was given: a file, or the command line.

    Raises:
        InputError: an unknown name, a bad value, or a required parameter that was not given.
    """
    known = {spec.name: spec for spec in specs(table)}
    for name in given:
        if name not in known:
            near = get_close_matches(name, known, n=1)
            wanted = f"did you mean {near[0]}?" if near else f"known: {', '.join(known)}"
            expected = f"a parameter of this node ({wanted})"
            raise InputError(origins.get(name, "command line"), name, expected, "an unknown name")
    values = {}
    for name, spec in known.items():
        value = given.get(name, spec.default)
        if value is REQUIRED:
            raise InputError("parameters", name, f"{expectation(spec)}: {spec.text}", "nothing")
        origin = origins.get(name, "command line") if name in given else "default"
        values[spec.attribute] = check(spec, value, origin)
    return table(**values)


def _scalar(kind: type, value: Any) -> Any:
    """The value as `kind`, None when it is of another type."""
    if kind is str:
        return value if isinstance(value, str) else None
    if kind is bool:
        return bool(value) if isinstance(value, bool) else None
    if isinstance(value, bool):
        return None
    if kind is int:
        return int(value) if isinstance(value, Integral) else None
    return float(value) if isinstance(value, Real) else None


def _allowed(spec: Spec, entry: Any) -> bool:
    if isinstance(entry, str):
        return not spec.choices or entry in spec.choices
    return math.isfinite(entry) and spec.low <= entry <= spec.high


def _as_list(value: Any) -> list[Any] | None:
    if isinstance(value, (str, bytes)) or not hasattr(value, "__iter__"):
        return None
    return list(value)


def _shown(value: Any) -> str:
    text = str(list(value)) if _as_list(value) is not None else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
