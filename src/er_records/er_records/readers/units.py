"""Units that measurements state, their many spellings, and what they are in SI."""

from __future__ import annotations

import re

from er_models.constants import g

UNITS: dict[str, dict[str, float]] = {
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0},
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254, "ft": 0.3048},
    "m/s": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "in/s": 0.0254, "ft/s": 0.3048, "km/h": 1 / 3.6},
    "1": {"1": 1.0, "-": 1.0, "%": 1e-2},
    "N": {"N": 1.0, "kN": 1e3, "daN": 10.0, "kgf": g, "lbf": 4.4482216152605, "kip": 4448.2216152605},
    "m/s2": {"m/s2": 1.0, "m/s^2": 1.0, "mm/s2": 1e-3, "g": g, "ft/s2": 0.3048, "in/s2": 0.0254},
    "K": {"K": 1.0, "degC": 1.0, "degF": 5.0 / 9.0},
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "bar": 1e5, "psi": 6894.757293168},
}  # fmt: skip
"""SI unit to the accepted ways of stating it and their factors (by definition; psi rounded)."""
ZERO = {"degC": 0.0, "degF": 32.0}
"""What a scale of temperature shows at 0 degC, to which temperatures are differences."""
FIELD = {"A": "A", "mA": "A", "V": "V", "kV": "V", "mV": "V", "kV/mm": "V", "T": "T", "Hz": "Hz"}
"""Units of what drives the field of a damper: they become a duty by their full scale."""

_SPELLED = {
    "sec": "s", "sek": "s", "second": "s", "seconds": "s", "sekunden": "s", "msec": "ms", "usec": "us", "hr": "h",
    "inch": "in", "inches": "in", "ips": "in/s", "lb": "lbf", "lbs": "lbf", "kips": "kip", "klbf": "kip", "kp": "kgf",
    "newton": "N", "percent": "%", "prozent": "%", "degc": "degC", "degf": "degF", "celsius": "degC", "c": "degC",
    "fahrenheit": "degF", "f": "degF", "gradc": "degC", "kelvin": "K", "m/s/s": "m/s2", "mm/s/s": "mm/s2",
    "mm/sec": "mm/s", "m/sec": "m/s", "in/sec": "in/s", "kph": "km/h", "amp": "A", "ampere": "A", "volt": "V",
}  # fmt: skip
_IN_NAMES = {
    "mps": "m/s", "mmps": "mm/s", "mps2": "m/s2", "mpss": "m/s2", "ms2": "m/s2", "pct": "%",
}  # fmt: skip
"""Units as names spell them that have no room for a slash."""
_NO_UNIT = {"in", "1"}
"""What at the end of a name is rather an input or a count."""
_FOLD = str.maketrans(
    {"²": "2", "µ": "u", "μ": "u", "°": "deg", "º": "deg", "^": "", "*": "", "·": "", " ": ""}
)


def known_unit(si: str, unit: str) -> str | None:
    """The unit as `UNITS` writes it, for a quantity by its SI unit; None where it is none of it."""
    table = UNITS[si]
    folded = unit.strip().strip("[]()").translate(_FOLD)
    for spelled in (unit, folded, _SPELLED.get(folded.lower(), "")):
        if spelled in table:
            return spelled
    same = [each for each in table if each.lower() == folded.lower()]
    return same[0] if len(same) == 1 else None


def quantities(unit: str) -> list[str]:
    """SI units of the quantities that a stated unit may be of; '1' also for what drives a field."""
    found = [si for si in UNITS if unit and known_unit(si, unit)]
    return found or (["1"] if field_unit(unit) else [])


def field_unit(unit: str) -> bool:
    """Whether a unit is of a current, a voltage, or another drive of the field."""
    folded = unit.strip().strip("[]()").translate(_FOLD)
    return folded in FIELD or _SPELLED.get(folded.lower()) in FIELD


def unit_in_name(si: str, name: str) -> str:
    """The unit that a name ends with (`disp_mm`, `vel_mm_s`, `Kraft kN`), for a quantity by its SI unit; '' without.

    A single letter is a unit only as the unit is written: `x_N` is no number of newtons in a column `x_n`.
    """
    parts = re.split(r"[_\s.-]+", name.strip())
    for n in (2, 1):
        if len(parts) <= n:
            continue
        stated = "/".join(parts[-n:])
        stated = _IN_NAMES.get(stated.lower(), stated)
        known = known_unit(si, stated) or (stated if si == "1" and field_unit(stated) else "")
        exact = len(stated) > 1 or stated in UNITS[si] or stated in FIELD or stated in ("C", "F")
        if known and exact and stated.lower() not in _NO_UNIT:
            return known
    return ""


def looks_like_unit(cell: str) -> bool:
    """Whether a cell of a table is a unit, in brackets or not."""
    bare = cell.strip().strip('"').strip()
    return bool(re.fullmatch(r"[\[(].{0,12}[\])]", bare)) or bool(quantities(bare))
