"""Numbers as an engineer reads them: display units, significant digits, ranges."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from er_model_lab.residual.region import Region
from er_model_lab.view import Array

MINUS = "\N{MINUS SIGN}"
MILLI = {"m": "mm", "m/s": "mm/s"}
"""SI units that are shown in thousandths, because a damper moves by millimetres."""

PREFIXES = {-3: "n", -2: "\N{MICRO SIGN}", -1: "m", 0: "", 1: "k", 2: "M", 3: "G"}
"""Prefix of a unit by its power of a thousand."""
PREFIXED, LARGE = re.compile(r"(N|J|W|Hz|m|s)(?!\w)"), ("N", "J", "W", "Hz")
"""Beginning of a unit that may carry a prefix, and those of them that also carry one for thousands."""
ROUNDING = 1e-9
"""Share of a range below which an end of it is zero."""


def factor(unit: str) -> float:
    """Multiplier from SI to the unit shown."""
    return 1e3 if unit in MILLI else 1.0


def shown(unit: str) -> str:
    """Name of the unit shown; empty for pure numbers."""
    return "" if unit in ("1", "") else MILLI.get(unit, unit)


def labelled(quantity: str, unit: str) -> str:
    """Axis label: quantity and the unit shown."""
    return f"{quantity} [{shown(unit)}]" if shown(unit) else quantity


def short(value: float | None, digits: int = 3) -> str:
    """A number with significant digits, plain where it can be; a dash when there is none."""
    if value is None or not math.isfinite(value):
        return "-"
    if value != 0.0 and not 1e-4 <= abs(value) < 10.0 ** (digits + 2):
        return f"{value:.{digits - 1}e}".replace("-", MINUS)
    places = digits - 1 - math.floor(math.log10(abs(value))) if value else 0
    text = f"{value:.{max(places, 0)}f}"
    return text.replace("-", MINUS)


def newtons(value: float | None) -> str:
    """A force with its unit; a dash where there is none."""
    text = short(value)
    return text if text == "-" else f"{text} N"


def moves(before: float | None, after: float | None) -> str:
    """What an error does, in a clause: falls, rises, or stays where both read alike."""
    old, new = newtons(before), newtons(after)
    if before is None or after is None or old == new:
        return f"stays at {new}"
    return f"{'falls' if after < before else 'rises'} from {old} to {new}"


def arrow(before: float | None, after: float | None) -> str:
    """An error before and after, short."""
    old, new = newtons(before), newtons(after)
    return f"{old}, unchanged" if old == new else f"{old} \N{RIGHTWARDS ARROW} {new}"


def gain(size: float | None, largest: float) -> str:
    """An effect size in newtons; in words where it is nothing beside the largest one."""
    if size is None or not math.isfinite(size):
        return "-"
    return newtons(size) if size > 0.005 * largest else "no gain"


def percent(value: float | None) -> str:
    """A share as a percentage, with a decimal only where it is small, or nearly all: what is not all is not 100 %."""
    if value is None or not math.isfinite(value):
        return "-"
    if abs(value) < 5e-4:
        return "0 %"
    if 0.995 <= value < 1.0:
        return f"{min(round(100.0 * value, 1), 99.9)} %"
    text = f"{100.0 * value:.1f} %" if abs(value) < 0.0995 else f"{100.0 * value:.0f} %"
    return text.replace("-", MINUS)


def change(before: float, after: float) -> str:
    """Relative change with its sign; none where it rounds to nothing."""
    text = f"{100.0 * (after / before - 1.0):+.0f} %".replace("-", MINUS)
    return "0 %" if text[1:] == "0 %" else text


def engineering(size: float, unit: str) -> tuple[float, str]:
    """Multiplier from SI, and unit, in which a value of this size reads best: kN/m, mm; empty for pure numbers."""
    found = PREFIXED.match(unit)
    if not found or not size >= 0.1 * 1e3 ** min(PREFIXES) or not math.isfinite(size):
        return 1.0, "" if unit == "1" else unit
    most, power = max(PREFIXES) if found[1] in LARGE else 0, 0
    while size >= 1e4 * 1e3**power and power < most:
        power += 1
    while size < 0.1 * 1e3**power and power > min(PREFIXES):
        power -= 1
    return 1e3**-power, PREFIXES[power] + unit


def quantity(value: float | None, unit: str) -> str:
    """A value in the unit in which an engineer reads it; a dash where there is none."""
    if value is None or not math.isfinite(value):
        return "-"
    factor, name = engineering(abs(value), unit)
    return f"{short(value * factor)} {name}".strip()


def parameter(triple: Sequence[Any], digits: int = 2) -> str:
    """Value, standard deviation with `digits` significant digits, and unit as an engineer reads it."""
    value, sd = float(triple[0]), math.inf if triple[1] is None else abs(float(triple[1]))
    factor, unit = engineering(max(abs(value), sd if math.isfinite(sd) else 0.0), str(triple[2]))
    text = with_deviation(value * factor, sd * factor, digits) + f" {unit}".rstrip()
    return text if math.isfinite(sd) else f"{text} (not determined by these data)"


def estimate(entry: Mapping[str, Any]) -> tuple[str, str, str]:
    """Value before, value with its deviation, and bounds of an estimated parameter, all in one unit."""
    sd, before = entry.get("sd"), entry.get("before")
    told = [abs(float(v)) for v in (entry["value"], sd or 0.0) if math.isfinite(float(v))]
    factor, unit = engineering(
        max(told, default=0.0) or abs(float(before or 0.0)), str(entry["unit"])
    )
    unit = f" {unit}".rstrip()
    value = with_deviation(float(entry["value"]) * factor, float(sd or 0.0) * factor)
    ends = _range(entry.get("bounds") or (), str(entry["unit"]))
    was = "" if before is None else short(float(before) * factor, 4) + unit
    return was, value + unit, ends


def _range(ends: Sequence[float], unit: str) -> str:
    """Two values and their unit; empty without them."""
    factor, name = engineering(max((abs(v) for v in ends), default=0.0), unit)
    text = " to ".join(short(v * factor) for v in ends)
    return f"{text} {name}".strip() if ends else ""


def with_deviation(value: float, sd: float, digits: int = 2) -> str:
    """A value to the digits that its standard deviation leaves it; three digits where that is 0 or unknown."""
    if sd == 0.0 or not math.isfinite(sd):
        return short(value)
    places = digits - 1 - math.floor(math.log10(sd))
    if not -9 < places < 7:
        return f"{short(value, 4)} \N{PLUS-MINUS SIGN} {short(sd, digits)}"
    both = (f"{round(y, places):.{max(places, 0)}f}" for y in (value, sd))
    return " \N{PLUS-MINUS SIGN} ".join(both).replace("-", MINUS)


def discrete(regions: Sequence[Region]) -> bool:
    """Whether the bins are single values, like duties held, not ranges."""
    return regions[-1].edges[0] == regions[-1].edges[1]


def where(region: Region, *, single: bool) -> str:
    """The range of a region in words: "velocity -12 to 3.4 mm/s", "direction: extension"."""
    if region.quantity == "direction" and single:
        return f"direction: {_direction(region.edges[0])}"
    span = region.edges[1] - region.edges[0]
    low, high = (
        0.0 if abs(e) < ROUNDING * span else e * factor(region.unit) for e in region.edges
    )
    unit = f" {shown(region.unit)}" if shown(region.unit) else ""
    if single:
        return f"{region.quantity} {short(low)}{unit}"
    return f"{region.quantity} {short(low, 2)} to {short(high, 2)}{unit}"


def _direction(sign: float) -> str:
    """Direction of the motion by the sign of the velocity."""
    return "rest" if sign == 0 else "extension" if sign > 0 else "compression"


def ticks(regions: Sequence[Region]) -> tuple[tuple[float, str], ...]:
    """Ticks for bars at 0, 1, 2...: single values under the bars, or the edges between them."""
    single = discrete(regions)
    if single and regions[0].quantity == "direction":
        return tuple((float(k), _direction(r.edges[0])) for k, r in enumerate(regions))
    values = [r.edges[0] for r in regions] + ([] if single else [regions[-1].edges[1]])
    texts = _apart([v * factor(regions[0].unit) for v in values])
    return tuple((k - (0.0 if single else 0.5), text) for k, text in enumerate(texts))


def _apart(values: Sequence[float]) -> list[str]:
    """Numbers with two digits of the largest, or with as many as tell them apart; no digit is wasted on small ones."""
    scale = max(abs(v) for v in values) or 1.0
    first = max(1 - math.floor(math.log10(scale)), 0)
    texts: list[str] = []
    for places in range(first, first + 3):
        texts = [f"{v:.{places}f}".replace("-", MINUS) for v in values]
        if len(set(texts)) == len(texts):
            break
    # what rounding left of zero is zero
    return ["0" if not text.strip("0." + MINUS) else text for text in texts]


def scaled(y: Array, unit: str) -> Array:
    """Array y (n,) in the unit shown."""
    return y * factor(unit)
