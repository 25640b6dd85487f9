r"""Measured terms: force that no known effect explains, as a smooth function that was learnt; measured, not explained.

A term is a tensor product of cubic B-splines over one or two quantities, times the duty where that is said:

.. math::  F = m \\sum_{ij} c_{ij} B_i(q_1) B_j(q_2), \\quad m = 1 \\text{ or } u

It adds to the damper force behind all effects that do, before limits and sensors. Outside the range that was learnt
each quantity is held at its end. The numbers stand in the model file; the equation in `kernel/terms.py`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from er_models.errors import InputError

LABEL = "measured, not explained"
PREFIX = "measured_"
QUANTITIES: dict[str, tuple[str, str]] = {
    "deflection": ("x", "m"), "velocity": ("v", "m/s"), "acceleration": ("a", "m/s2"), "duty": ("u", "1"),
    "formed_duty": ("u_f", "1"), "yield_force": ("f_y", "N"), "temperature": ("theta", "K"), "force": ("f_d", "N"),
}  # fmt: skip
"""What a term may depend on: signal of `effect.SIGNALS` and unit, in the order in which the kernel counts them."""
LAGGED = "_lagged"
"""End of the name of a quantity that a term sees through a first-order lag."""
ORDER = 4
"""Coefficients that act at a point, along each quantity: cubic splines."""
_KEYS = ("label", "quantities", "times", "lag", "range", "shape", "knots", "coefficients", "deviations")  # fmt: skip


def is_term(name: str | None) -> bool:
    """Whether a name is that of a measured term, which explains nothing."""
    return str(name).startswith(PREFIX)


@dataclass(frozen=True)
class MeasuredTerm:
    """One term.

    quantities: one or two of `QUANTITIES`, perhaps with `LAGGED`; knots (n_i + 4,) of each, in its unit;
    coefficients and their standard deviations (n_1 * n_2,), the second quantity counting fastest [N], or [N] per unit
    of `times`, a quantity or empty; lag: time constant [s] of what is lagged; shape: what the data said of it.
    """

    quantities: tuple[str, ...]
    knots: tuple[tuple[float, ...], ...]
    coefficients: tuple[float, ...]
    deviations: tuple[float, ...]
    times: str = ""
    lag: float = 0.0
    shape: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "knots", tuple(tuple(map(float, k)) for k in self.knots))
        for name in ("coefficients", "deviations"):
            object.__setattr__(self, name, tuple(map(float, getattr(self, name))))

    @property
    def name(self) -> str:
        """`measured_` and its quantities."""
        return PREFIX + "_".join(q for q in (*self.quantities, self.times) if q)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Number of coefficients along each quantity."""
        return tuple(len(k) - ORDER for k in self.knots)

    @property
    def ranges(self) -> tuple[tuple[float, float], ...]:
        """What was learnt of each quantity: beyond it the term is held constant."""
        return tuple((k[ORDER - 1], k[-ORDER]) for k in self.knots)

    @property
    def signals(self) -> frozenset[str]:
        """Signals that it reads, `lagged` among them where one is."""
        names = (*self.quantities, self.times)
        read = {QUANTITIES[q.removesuffix(LAGGED)][0] for q in names if q}
        return frozenset(read | ({"lagged"} if any(q.endswith(LAGGED) for q in names) else set()))

    def as_json(self) -> dict[str, Any]:
        """Plain data, as the model file holds it."""
        many = self.sizes[1] if len(self.sizes) > 1 else 1
        table = {"coefficients": self.coefficients, "deviations": self.deviations}
        ends = zip(self.quantities, self.ranges, strict=True)
        return {
            "label": LABEL, "quantities": list(self.quantities), "times": self.times, "lag": self.lag,
            "shape": list(self.shape), "range": {q: list(r) for q, r in ends},
            "knots": {q: list(k) for q, k in zip(self.quantities, self.knots, strict=True)},
            **{key: [list(c[i : i + many]) for i in range(0, len(c), many)] for key, c in table.items()},
        }  # fmt: skip


def packed(terms: Sequence[MeasuredTerm]) -> NDArray[np.float64]:
    """The numbers of some terms as `kernel/terms.py` reads them, behind the parameters of the effects."""
    order = [f"{name}{end}" for end in ("", LAGGED) for name in QUANTITIES]
    lagged = [q for term in terms for q in term.quantities if q.endswith(LAGGED)]
    head = [float(len(terms)), -1.0, 0.0]
    if lagged:
        lag = next(t.lag for t in terms if lagged[0] in t.quantities)
        head[1:] = [float(order.index(lagged[0]) - len(QUANTITIES)), 1.0 / lag]

    def place(name: str) -> float:
        return float(min(order.index(name), len(QUANTITIES))) if name else -1.0

    for t in terms:
        first, second = (*t.quantities, "")[:2]
        n, m = (*t.sizes, 1)[:2]
        head += [place(first), place(second), place(t.times), float(n), float(m)]
        head += [*chain(*t.knots), *t.coefficients]
    return np.array(head)


def read_terms(path: Path, found: Any) -> tuple[MeasuredTerm, ...]:
    """Terms of a model file; `InputError` names what is wrong with them."""
    if not isinstance(found, Mapping):
        raise InputError(
            path, "measured_terms", "a mapping of names to terms", type(found).__name__
        )
    terms = tuple(_read(path, f"measured_terms.{name}", entry) for name, entry in found.items())
    for name, term in zip(found, terms, strict=True):
        if name != term.name:
            raise InputError(path, "measured_terms", f"the name {term.name}", str(name))
    lagged = {(q, t.lag) for t in terms for q in t.quantities if q.endswith(LAGGED)}
    if len(lagged) > 1:
        raise InputError(path, "measured_terms", "one lagged quantity in all", f"{len(lagged)}")
    return terms


def _read(path: Path, where: str, entry: Any) -> MeasuredTerm:
    """One term of a model file."""
    if not isinstance(entry, Mapping) or set(entry) - set(_KEYS):
        raise InputError(
            path, where, f"a mapping with the keys {', '.join(_KEYS)}", repr(entry)[:60]
        )
    quantities = _names(path, f"{where}.quantities", entry.get("quantities"))
    times, lag = (
        str(entry.get("times") or ""),
        _floats(path, f"{where}.lag", [entry.get("lag", 0.0)])[0],
    )
    if times and times not in QUANTITIES:
        raise InputError(
            path, f"{where}.times", f"one of {', '.join(QUANTITIES)}, or empty", times
        )
    if any(q.endswith(LAGGED) for q in quantities) and not lag > 0.0:
        raise InputError(path, f"{where}.lag", "a time above 0 s", f"{lag:g}")
    knots = tuple(
        _knots(path, f"{where}.knots.{q}", (entry.get("knots") or {}).get(q)) for q in quantities
    )
    count = int(np.prod([len(k) - ORDER for k in knots]))
    tables = {}
    for key in ("coefficients", "deviations"):
        rows = entry.get(key)
        flat = [c for row in rows or () for c in row] if _nested(rows) else []
        if len(flat) != count:
            raise InputError(path, f"{where}.{key}", f"{count} numbers in rows", "others")
        tables[key] = _floats(path, f"{where}.{key}", flat)
    shape = tuple(map(str, entry.get("shape") or ()))
    term = MeasuredTerm(
        quantities, knots, tables["coefficients"], tables["deviations"], times, lag, shape
    )
    ends = {q: list(r) for q, r in zip(quantities, term.ranges, strict=True)}
    if entry.get("range", ends) != ends:
        raise InputError(
            path, f"{where}.range", f"that of the knots, {ends}", repr(entry["range"])[:60]
        )
    return term


def _nested(rows: Any) -> bool:
    """Whether it is a list of lists."""
    return isinstance(rows, list) and all(isinstance(row, list) for row in rows)


def _names(path: Path, where: str, found: Any) -> tuple[str, ...]:
    """One or two quantities."""
    names = tuple(map(str, found)) if isinstance(found, list) else ()
    if len(set(names)) not in (1, 2) or len(set(names)) != len(names):
        raise InputError(path, where, "one or two quantities", repr(found))
    for name in names:
        if name.removesuffix(LAGGED) not in QUANTITIES:
            raise InputError(path, where, f"some of {', '.join(QUANTITIES)}", name)
    return names


def _knots(path: Path, where: str, found: Any) -> tuple[float, ...]:
    """Knots that never fall, and rise where the spline is used."""
    knots = _floats(path, where, found)
    inner = knots[ORDER - 1 : len(knots) - ORDER + 1]
    if len(knots) < 2 * ORDER or np.any(np.diff(knots) < 0.0) or np.any(np.diff(inner) <= 0.0):
        raise InputError(path, where, f"at least {2 * ORDER} numbers that rise", repr(found)[:60])
    return knots


def _floats(path: Path, where: str, found: Any) -> tuple[float, ...]:
    """Finite numbers of a list."""
    numbers = found if isinstance(found, list) else []
    plain = all(isinstance(c, int | float) and not isinstance(c, bool) for c in numbers)
    if not numbers or not plain or not np.isfinite(numbers).all():
        raise InputError(path, where, "finite numbers", repr(found)[:60])
    return tuple(map(float, numbers))
