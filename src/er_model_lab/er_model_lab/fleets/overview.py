"""All units beside one another: what they share, which differ and in what, what changes, what to record next.

Everything here is arithmetic on rows: no recording is opened.
"""

from __future__ import annotations

import math
from array import array
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.stats import beta

from er_model_lab.fleets.pooled import (
    FEWEST,
    RATE,
    Array,
    Mask,
    Places,
    Pooled,
    discoveries,
    means,
    pooled,
)
from er_model_lab.fleets.trends import Trend, scatter, spread_within, trend
from er_model_lab.fleets.two_groups import two_groups

Row = Mapping[str, Any]
AXES = ("mileage", "time")
GROUPS = "recordings"
"""In place of an axis where the values of a unit fall into two groups, whatever their order."""
COMMON = 0.5
"""Share of the units from which an effect is one of the kind, not of a unit [1]."""
ERROR = "ln rmse"
"""What the refitted model leaves of a recording, as its logarithm: it rises with whatever the model does not hold."""
MOST_NEXT = 2
"""Suggestions a unit gets, at most."""
CREDIBLE = 1e-6
"""Smallest deviation over value that a measurement has [1]."""
USELESS = 1e4
"""Deviation over value from which a value says nothing [1]."""
LOOSE = 0.3
"""Deviation over value from which a unit's own data are too few for a parameter [1]."""


@dataclass
class _Series:
    """Values of one quantity over recordings, as they come: unit, its place along each axis, value, deviation."""

    unit: array[int] = field(default_factory=lambda: array("q"))
    x: tuple[array[float], ...] = field(default_factory=lambda: tuple(array("d") for _ in AXES))
    y: array[float] = field(default_factory=lambda: array("d"))
    s: array[float] = field(default_factory=lambda: array("d"))


@dataclass(frozen=True)
class Overview:
    """The fleet in numbers.

    content: plain data for JSON; units: what each unit's row gets: `p`, `differs`, `differs_in`, `changes`, `pooled`
    ({parameter: [value, deviation]}), `next`.
    """

    content: dict[str, Any]
    units: dict[str, dict[str, Any]]


@dataclass(frozen=True)
class _Tested:
    """One quantity over the fleet.

    pooled: what its units have in common, where `place` says which is which; p: probability of each by chance, where
    units are held against one another; trends: of each unit along each axis; within: spread within units.
    """

    name: str
    pooled: Pooled | None
    place: dict[str, int]
    p: Array
    trends: dict[str, dict[str, Trend]]
    within: float

    def chance(self, unit: str) -> list[tuple[str, float]]:
        """What the unit may differ in here, with its probability by chance."""
        k = self.place.get(unit, self.p.size)
        found = [(self.name, float(self.p[k]))] if k < self.p.size else []
        return found + [(_told(self.name, a), t.p) for a, t in self.trends.get(unit, {}).items()]


def overview(units: Iterable[Row], recordings: Iterable[Row]) -> Overview:
    """The fleet of units and recordings, rows as the tables hold them."""
    rows = {str(row["unit"]): row for row in units}
    names = list(rows)
    series, count = _series(recordings, {name: k for k, name in enumerate(names)})
    units_of = _unit_names(rows, series)
    tested = [_tested(name, rows, names, own) for name, own in sorted(series.items())]
    tested += [
        t
        for name in units_of
        if name not in series and (t := _effect_value(name, rows)) is not None
    ]
    effects = _effects(rows)
    rare = {e["effect"] for e in effects if e["share"] < COMMON}
    chances = {name: _chances(name, rows[name], tested, rare) for name in names}
    p = np.array(
        [min((q for _, q in chances[n]), default=1.0) * max(len(chances[n]), 1) for n in names]
    )
    p = np.minimum(p, 1.0)
    named = discoveries(p, RATE)
    told = {
        name: _unit(
            name, rows[name], tested, chances[name], float(p[k]), bool(named[k]), _limit(named)
        )
        for k, name in enumerate(names)
    }
    return Overview(_content(rows, count, effects, tested, told, units_of), told)


def _told(name: str, axis: str) -> str:
    """What a unit differs in where a quantity changes, or falls into two groups."""
    return f"{name} in two groups" if axis == GROUPS else f"{name} over {axis}"


def _limit(named: Mask) -> float:
    """Probability below which a quantity of a named unit is told."""
    return RATE * max(int(named.sum()), 1) / max(named.size, 1)


def _series(
    recordings: Iterable[Row], places: Mapping[str, int]
) -> tuple[dict[str, _Series], Counter[str]]:
    """Values of each quantity over recordings, and how many recordings have which status."""
    found: dict[str, _Series] = {}
    count: Counter[str] = Counter()
    for row in recordings:
        count[str(row["status"])] += 1
        place = places.get(str(row["unit"]))
        if row["status"] != "used" or place is None:
            continue
        for name, value, sd in _values(row):
            own = found.setdefault(name, _Series())
            own.unit.append(place)
            own.y.append(value)
            own.s.append(sd)
            for axis, x in zip(AXES, own.x, strict=True):
                x.append(math.nan if row.get(axis) is None else float(row[axis]))
    return found, count


def _values(row: Row) -> Iterable[tuple[str, float, float]]:
    """Quantities of a recording with their deviations, those that are known."""
    for name, (value, sd, _) in (row.get("values") or {}).items():
        if _known(value, sd):
            yield name, float(value), float(sd)
    left = row.get("rmse_refitted")
    if left:
        yield ERROR, math.log(left), 1.0 / math.sqrt(2.0 * float(row.get("independent") or 2.0))


def _known(value: float | None, sd: float | None) -> bool:
    """Whether a value is determined: a deviation of zero is that of a value that was never moved."""
    if value is None or sd is None:
        return False
    return CREDIBLE * abs(value) < sd < (USELESS * abs(value) if value else math.inf)


def _unit_names(rows: Mapping[str, Row], series: Iterable[str]) -> dict[str, str]:
    """Quantities and their SI units."""
    found = {name: "1" for name in series}
    for row in rows.values():
        found |= {name: unit for name, (_, _, unit) in (row.get("values") or {}).items()}
    return found


def _tested(name: str, rows: Mapping[str, Row], names: Sequence[str], own: _Series) -> _Tested:
    """A quantity that recordings give."""
    unit, y, s = np.array(own.unit, np.intp), np.array(own.y), np.array(own.s)
    axes = {axis: np.array(x) for axis, x in zip(AXES, own.x, strict=True)}
    axes = {axis: x for axis, x in axes.items() if np.isfinite(x).mean() > COMMON}
    within, trends = _changes(unit, y, s, axes, names)
    there, place = np.unique(unit, return_inverse=True)
    value, v = means(place, y, s**2 + within**2, there.size)
    sd = np.sqrt(v)
    for k, number in enumerate(
        there
    ):  # what the diagnosis found beside its effects is freer of bias
        best = (rows[names[number]].get("values") or {}).get(name)
        if best and name != ERROR and _known(best[0], best[1]):
            value[k], sd[k] = best[0], math.sqrt(best[1] ** 2 + within**2 / np.sum(place == k))
    common = None if name == ERROR else pooled(np.arange(there.size), value, sd, 0.0)
    p = common.p if common else np.zeros(0)
    return _Tested(name, common, {names[k]: i for i, k in enumerate(there)}, p, trends, within)


def _changes(
    unit: Places, y: Array, s: Array, axes: Mapping[str, Array], names: Sequence[str]
) -> tuple[float, dict[str, dict[str, Trend]]]:
    """Spread within units, and what changes in which unit along which axis; those that change do not widen it."""
    x = next(iter(axes.values()), np.arange(y.size, dtype=float))
    within = scatter(unit, np.nan_to_num(x), y, s)
    if within is None:
        return 0.0, {}
    found: dict[str, dict[str, Trend]] = {}
    for _ in range(2):
        freedom = max(y.size - np.unique(unit).size, 1)
        variance = np.maximum(s**2 + within**2, 1e-300)
        each = [
            (k, axis, seen)
            for k, own in _by_unit(unit)
            for axis, seen in _forms(own, y, variance, axes, freedom)
        ]
        found = {names[k]: {} for k, _, _ in each}
        for k, axis, seen in each:
            found[names[k]][axis] = seen
        moving = discoveries(np.array([seen.p for _, _, seen in each]), RATE)
        steady = ~np.isin(unit, [k for (k, _, _), bad in zip(each, moving, strict=True) if bad])
        if np.bincount(unit[steady], minlength=1).max(initial=0) > 1:
            _, place = np.unique(unit[steady], return_inverse=True)
            within = spread_within(place, y[steady], s[steady])
    return within, found


def _forms(
    own: Places, y: Array, variance: Array, axes: Mapping[str, Array], freedom: int
) -> Iterator[tuple[str, Trend]]:
    """What the values of a unit at these places show along each axis, and whether they fall into two groups."""
    least = math.inf
    for axis, along in axes.items():
        if (seen := trend(along[own], y[own], variance[own], freedom)) is not None:
            least = min(least, seen.criterion)
            yield axis, seen
    if (seen := two_groups(y[own], variance[own], freedom, least)) is not None:
        yield GROUPS, seen


def _by_unit(unit: Places) -> Iterator[tuple[int, Places]]:
    """Each unit with the places of its values."""
    order = np.argsort(unit, kind="stable")
    cuts = np.flatnonzero(np.diff(unit[order])) + 1
    for own in np.split(order, cuts):
        if own.size:
            yield int(unit[own[0]]), own


def _effect_value(name: str, rows: Mapping[str, Row]) -> _Tested | None:
    """A parameter of an effect that some units show, over these."""
    known = {
        unit: row["values"][name]
        for unit, row in rows.items()
        if name in (row.get("values") or {})
    }
    known = {u: t for u, t in known.items() if _known(t[0], t[1])}
    if len(known) < FEWEST:
        return None
    y, s = (np.array([t[k] for t in known.values()], float) for k in (0, 1))
    common = pooled(np.arange(y.size), y, s, 0.0)
    if common is None:
        return None
    return _Tested(name, common, {unit: k for k, unit in enumerate(known)}, common.p, {}, 0.0)


def _effects(rows: Mapping[str, Row]) -> list[dict[str, Any]]:
    """Effects that units show: how many, and the share with its 90 % interval (Clopper and Pearson 1934)."""
    asked = [row for row in rows.values() if row.get("effects") is not None]
    n, found = len(asked), Counter(e for row in asked for e in row["effects"])
    return [
        {
            "effect": effect, "units": k, "share": k / n, "low": float(beta.ppf(0.05, k, n - k + 1)),
            "high": float(beta.ppf(0.95, k + 1, n - k)) if k < n else 1.0,
        }
        for effect, k in found.most_common()
    ]  # fmt: skip


def _chances(
    name: str, row: Row, tested: Sequence[_Tested], rare: set[str]
) -> list[tuple[str, float]]:
    """Everything that a unit may differ in, each with its probability by chance."""
    found = [pair for t in tested for pair in t.chance(name)]
    if row.get("candidates") is not None:
        shown = [
            (e, float(row["candidates"][e][2]))
            for e in row["effects"]
            if e in rare and e in row["candidates"]
        ]
        found.append(min(shown, key=lambda pair: pair[1], default=("effects", 1.0)))
    return found


def _unit(
    name: str, row: Row, tested: Sequence[_Tested], chances: Sequence[tuple[str, float]], p: float,
    named: bool, limit: float,
) -> dict[str, Any]:  # fmt: skip
    """What a unit's row gets."""
    certain = [
        what for what, q in sorted(chances, key=lambda c: c[1]) if q * len(chances) <= limit
    ]
    changes = [
        {"quantity": t.name, "axis": axis, **_change(seen)}
        for t in tested for axis, seen in t.trends.get(name, {}).items()
        if named and _told(t.name, axis) in certain
    ]  # fmt: skip
    values = {
        t.name: [float(t.pooled.value[k]), float(t.pooled.value_sd[k]), float(t.pooled.weight[k])]
        for t in tested if t.pooled is not None and name in t.place
        for k in [t.place[name]]
    }  # fmt: skip
    return {
        "p": p, "differs": named, "differs_in": certain if named else [],
        "changes": sorted(changes, key=lambda c: float(c["p"])), "pooled": values,
        "next": _next(row)[:MOST_NEXT],
    }  # fmt: skip


def _change(found: Trend) -> dict[str, Any]:
    """A change as plain data."""
    return {
        "form": found.form, "at": found.at, "low": found.low, "high": found.high, "change": found.change,
        "sd": found.sd, "p": found.p,
    }  # fmt: skip


def _next(row: Row) -> list[dict[str, Any]]:
    """What to record next of a unit: what tells tied effects apart, what is missing, what is loose."""
    found: list[dict[str, Any]] = [
        {"between": list(plan["between"]), "why": "the data cannot tell them apart"} if "between" in plan
        else {"reveal": plan["reveal"], "why": "the data do not excite it"}
        for plan in row.get("next") or ()
    ]  # fmt: skip
    found += [{"record": hint, "why": "the data lack it"} for hint in row.get("hints") or ()]
    loose = sorted(
        (
            (v[1] / abs(v[0]), name)
            for name, v in (row.get("values") or {}).items()
            if v[0] and v[1]
        ),
        reverse=True,
    )
    found += [
        {"record": "a longer run", "why": f"the deviation of {name} is {share:.0%} of its value"}
        for share, name in loose
        if share > LOOSE
    ]
    return found


def _content(
    rows: Mapping[str, Row], count: Counter[str], effects: list[dict[str, Any]], tested: Sequence[_Tested],
    told: Mapping[str, Mapping[str, Any]], units_of: Mapping[str, str],
) -> dict[str, Any]:  # fmt: skip
    """The fleet as plain data."""
    strange = sorted((u for u in told if told[u]["differs"]), key=lambda u: float(told[u]["p"]))
    return {
        "units": len(rows), "recordings": sum(count.values()), "statuses": dict(count.most_common()),
        "verdicts": dict(Counter(str(row["verdict"]) for row in rows.values()).most_common()),
        "effects": effects, "common_effects": [e["effect"] for e in effects if e["share"] >= COMMON],
        "parameters": {
            t.name: {
                "mean": t.pooled.mean, "sd": t.pooled.sd, "between": t.pooled.between, "within": t.within,
                "unit": units_of.get(t.name, "1"), "units": len(t.place),
            }
            for t in tested if t.pooled is not None
        },
        "differ": [
            {"unit": u, "p": told[u]["p"], "in": told[u]["differs_in"], "changes": told[u]["changes"]} for u in strange
        ],
        "record_next": [
            {"unit": u, **each}
            for u in sorted(told, key=lambda u: float(told[u]["p"])) for each in told[u]["next"]
        ],
    }  # fmt: skip
