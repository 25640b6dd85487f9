"""What the part that no known effect explains depends on, in numbers and sentences, so that its effect can be written.

Every share is that of the residual's variance on seconds that were not looked at: half of the seconds teach, the
other half judge.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray

from er_model_lab.problem.problem import Problem
from er_model_lab.residual.excess import quantities
from er_model_lab.residual.spectral_lines import LEAST, longest, share_of, spectrum, stands_out

BINS = 24
"""Bins of a mean over a quantity; of equal numbers of samples."""
FEW = 8
"""A quantity with so few values gets a bin for each."""
WORTH = 0.03
"""Share from which a dependence is worth a word."""
PERIODS = 160
"""Periods of the deflection that are tried."""
FINEST, COARSEST = 24.0, 1.5
"""Shortest and longest of them: parts of the stroke in use."""
SHIFTS = 19
"""Times by which the residual is moved along the record to see what chance gives."""
ARGUMENTS: dict[str, str] = {
    "velocity": "v", "deflection": "x", "acceleration": "a", "duty": "u", "time": "t", "direction": "v",
    "duty change in the last 50 ms": "u", "temperature": "theta",
}  # fmt: skip
"""Argument of an effect's equation that carries a quantity."""
UNITS: dict[str, str] = {
    "v": "N s/m", "x": "N/m", "a": "kg", "u": "N/duty", "uv": "N s/m/duty", "ux": "N/m/duty",
}  # fmt: skip
"""Unit of a factor of the arguments, sorted; where the library has none, newtons."""
LOWEST_LINES = 0.05
"""Share of the power from which a spectral line counts."""


MOST = 12_000
"""Samples looked at."""
JOINT = ("velocity", "deflection", "duty", "acceleration", "temperature")
JOINT_BINS, MORE = 8, 0.08
"""Bins of each quantity of a pair, and the share by which a pair must beat either alone."""
Pairs = tuple[tuple[str, str, float], ...]


@dataclass(frozen=True)
class Curve:
    """Mean residual [N] with standard error over one quantity: at (b,), mean (b,), sd (b,); share explained."""

    quantity: str
    unit: str
    at: Array
    mean: Array
    sd: Array
    share: float

    @property
    def shape(self) -> str:
        """Odd, even, or neither, by what its mirror image has in common with it; empty for what has no two sides."""
        if self.at[0] >= 0.0 or self.at[-1] <= 0.0:
            return ""
        y = self.mean
        mirror = np.interp(-self.at, self.at, y)
        inner = np.abs(self.at) <= min(-self.at[0], self.at[-1])
        odd, even = y[inner] - mirror[inner], (y + mirror)[inner]
        total = float(np.sum(odd**2) + np.sum((even - even.mean()) ** 2))
        if total <= 0.0:
            return ""
        share = float(np.sum(odd**2)) / total
        return "odd" if share > 0.75 else "even" if share < 0.25 else "neither odd nor even"


@dataclass(frozen=True)
class Rest:
    """What is left and what it depends on: mean [N]; curves, best first; map of the two best; period; spectral lines.

    pairs: (quantity, quantity, share) that explain more together than alone;
    period: (length [m], amplitude [N], share) of a force periodic in the deflection, or None; lines: (frequency [Hz],
    amplitude [N], share); plane: (x, y, x edges, y edges, mean residual [N] (rows, columns)) or None;
    scales: natural sizes of force [N] and deflection [m], of which starts are multiples.
    """

    mean: float
    curves: tuple[Curve, ...]
    pairs: Pairs
    period: tuple[float, float, float] | None
    lines: tuple[tuple[float, float, float], ...]
    plane: tuple[tuple[str, str], tuple[str, str], Array, Array, Array] | None
    scales: tuple[float, float]

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        period = self.period
        return {
            "curves": [
                {
                    "quantity": c.quantity, "unit": c.unit, "at": c.at.tolist(), "mean": c.mean.tolist(),
                    "sd": c.sd.tolist(), "share": c.share, "shape": c.shape,
                }
                for c in self.curves
            ],
            "mean": self.mean,
            "pairs": [dict(zip(("x", "y", "share"), pair, strict=True)) for pair in self.pairs],
            "period": None if period is None else dict(zip(("length", "amplitude", "share"), period, strict=True)),
            "lines": [dict(zip(("frequency", "amplitude", "share"), line, strict=True)) for line in self.lines],
            "map": None if self.plane is None else {
                "x": self.plane[0][0], "x_unit": self.plane[0][1], "y": self.plane[1][0], "y_unit": self.plane[1][1],
                "x_edges": self.plane[2].tolist(), "y_edges": self.plane[3].tolist(),
                "mean": [[float(z) if np.isfinite(z) else None for z in row] for row in self.plane[4]],
            },
            "scales": list(self.scales),
            "says": list(sentences(self)),
            "arguments": arguments(self),
        }  # fmt: skip


def describe(problem: Problem, residual: Array) -> Rest:
    """Describe what a model leaves of the first output, residual (n * outputs,) [N]."""
    n, problem = problem.forward.outputs, problem.parts[0]
    residual = residual[::n]
    rows = np.flatnonzero(problem.used)
    rows = rows[:: max(1, rows.size // MOST)]
    teach = (rows // max(round(1.0 / problem.motion.dt), 1)) % 2 == 0
    mean = float(np.mean(residual[rows]))
    e = residual[rows] - mean
    known = [(q, u, y[rows]) for q, u, y in quantities(problem, problem.force - residual)]
    curves = [_curve(q, u, y, e, teach) for q, u, y in known]
    curves = sorted((c for c in curves if c.share > WORTH), key=lambda c: -c.share)
    if any(c.quantity == "velocity" for c in curves):
        curves = [c for c in curves if c.quantity != "direction"]
    pairs = _pairs(known, curves, e, teach)
    plane = _plane(known, curves, pairs, e)
    period = _period(problem.motion.x[rows], e, teach)
    scales = (problem.scales.force, problem.scales.deflection)
    return Rest(mean, tuple(curves[:4]), pairs, period, _lines(problem, residual), plane, scales)


def _pairs(
    known: list[tuple[str, str, Array]], curves: list[Curve], e: Array, teach: NDArray[np.bool_]
) -> Pairs:
    """Pairs of motion, duty and temperature whose mean over both explains much more than over either, best first."""
    alone = {c.quantity: c.share for c in curves}
    found = []
    for (a, _, x), (b, _, y) in itertools.combinations([k for k in known if k[0] in JOINT], 2):
        (i, m), (j, n) = _places(x, JOINT_BINS), _places(y, JOINT_BINS)
        share = _share(i * n + j, m * n, e, teach)
        if share > max(alone.get(a, 0.0), alone.get(b, 0.0), 0.0) + MORE:
            found.append((a, b, share))
    return tuple(sorted(found, key=lambda f: -f[2]))


def _share(place: NDArray[np.intp], bins: int, e: Array, teach: NDArray[np.bool_]) -> float:
    """Share of the residual that its mean per bin explains on the seconds that judge."""
    count = np.maximum(np.bincount(place[teach], minlength=bins), 1)
    learnt = np.bincount(place[teach], e[teach], bins) / count
    left = e[~teach] - learnt[place[~teach]]
    return 1.0 - float(np.mean(left**2)) / max(float(np.mean(e[~teach] ** 2)), 1e-300)


def _places(y: Array, many: int = BINS) -> tuple[NDArray[np.intp], int]:
    """Bin of each value and how many there are: a bin for each of few values, else equal numbers of samples."""
    levels = np.unique(np.round(y, 9))
    if levels.size <= FEW:
        return np.searchsorted(levels, np.round(y, 9)), levels.size
    edges = np.unique(np.quantile(y, np.linspace(0.0, 1.0, many + 1)))
    return np.clip(np.searchsorted(edges, y, side="right") - 1, 0, edges.size - 2), edges.size - 1


def _curve(quantity: str, unit: str, y: Array, e: Array, teach: NDArray[np.bool_]) -> Curve:
    """Mean of the residual over a quantity, and the share of it on the seconds that judge."""
    place, bins = _places(y)
    count = np.maximum(np.bincount(place, minlength=bins), 1)
    share = _share(place, bins, e, teach)
    mean, square = (np.bincount(place, e, bins) / count, np.bincount(place, e**2, bins) / count)
    at = np.bincount(place, y, bins) / count
    sd = np.sqrt(np.maximum(square - mean**2, 0.0) / np.maximum(count - 1, 1))
    return Curve(quantity, unit, at, mean, sd, share)


def _plane(
    known: list[tuple[str, str, Array]], curves: list[Curve], pairs: Pairs, e: Array
) -> tuple[tuple[str, str], tuple[str, str], Array, Array, Array] | None:
    """Mean residual over the two quantities that explain most, else over velocity and deflection."""
    wanted = list(pairs[0][:2]) if pairs else []
    wanted += [c.quantity for c in curves if c.quantity not in ("direction", "work done", *wanted)]
    wanted = wanted[:2]
    wanted += [q for q in ("velocity", "deflection") if q not in wanted]
    by_name = {q: (u, y) for q, u, y in known}
    (a, b), planes = wanted[:2], []
    for name in (a, b):
        unit, y = by_name[name]
        low, high = np.quantile(y, [0.005, 0.995])
        if high <= low:
            return None
        planes.append(((name, unit), np.linspace(low, high, 15), y))
    (x_name, x_edges, x), (y_name, y_edges, y) = planes
    count, _, _ = np.histogram2d(y, x, (y_edges, x_edges))
    total, _, _ = np.histogram2d(y, x, (y_edges, x_edges), weights=e)
    mean = np.where(count >= 5, total / np.maximum(count, 1.0), np.nan)
    return x_name, y_name, x_edges, y_edges, np.asarray(mean)


def _period(x: Array, e: Array, teach: NDArray[np.bool_]) -> tuple[float, float, float] | None:
    """Length [m], amplitude [N] and share of the best force that is periodic in the deflection, beyond chance.

    A sine beside a cubic, which takes what is no period; chance: the same with the residual moved along the record.
    """
    stroke = float(np.ptp(np.quantile(x, [0.01, 0.99])))
    if stroke <= 0.0:
        return None
    lengths = stroke / np.linspace(COARSEST, FINEST, PERIODS)
    shifts = np.linspace(0.1, 0.9, SHIFTS) * e.size
    moved = np.stack([e, *(np.roll(e, round(s)) for s in shifts)], axis=1)
    s = (x - x.mean()) / stroke
    smooth = np.stack([np.ones_like(s), s, s**2, s**3], axis=1)
    moved = moved - smooth @ np.linalg.lstsq(smooth[teach], moved[teach], rcond=None)[0]
    learn, rest = moved[teach], moved[~teach]
    power, shares, sizes = np.sum(rest**2, axis=0), [], []
    for length in lengths:
        angle = 2.0 * np.pi * x / length
        wave = np.stack([np.sin(angle), np.cos(angle)], axis=1)
        of, against = wave[teach], wave[~teach]
        c = np.linalg.lstsq(of.T @ of, of.T @ learn, rcond=None)[0]
        met = 2.0 * against.T @ rest - against.T @ against @ c
        shares.append(np.sum(c * met, axis=0) / power)
        sizes.append(float(np.hypot(*c[:, 0])))
    table = np.array(shares)
    best = int(np.argmax(table[:, 0]))
    share = float(table[best, 0] * power[0] / max(float(np.sum(e[~teach] ** 2)), 1e-300))
    if share < WORTH or table[best, 0] <= 1.5 * float(table[:, 1:].max()):
        return None
    return float(lengths[best]), sizes[best], share


def _lines(problem: Problem, residual: Array) -> tuple[tuple[float, float, float], ...]:
    """Up to three steady tones of the longest record that stand out, and that the motion lacks."""
    cut = longest(problem)
    y = problem.with_weight(residual)[cut]
    if y.size < LEAST:
        return ()
    power = spectrum(y)
    moved = [spectrum(s[cut]) for s in (problem.motion.v, problem.force - residual)]
    found: list[tuple[float, float, float]] = []
    left = power.copy()
    for _ in range(8):
        peak = int(np.argmax(left[2:])) + 2
        share = share_of(left, power, peak)
        if not stands_out(left, power, peak) or share < LOWEST_LINES or len(found) == 3:
            break
        left[max(peak - 5, 0) : peak + 6] = 0.0
        if not any(stands_out(m, m, p) for m in moved for p in range(peak - 1, peak + 2)):
            amplitude = float(np.sqrt(2.0 * share * np.var(y)))
            found.append((peak / (y.size * problem.motion.dt), amplitude, share))
    return tuple(found)


def sentences(rest: Rest) -> tuple[str, ...]:
    """What was found, in words."""
    out = []
    meaning = {
        ("velocity", "odd"): "it acts against the motion, as friction or damping",
        ("velocity", "even"): "it is the same in both directions, as an asymmetry",
        ("deflection", "odd"): "it acts as a spring",
        ("deflection", "even"): "it pushes one way at both ends",
        ("acceleration", "odd"): "it acts as a mass, or as a delay of a channel",
    }
    if rest.period:
        length, amplitude, share = rest.period
        size = f"amplitude {amplitude:.2g} N, {100 * share:.0f} % of it"
        out.append(f"it is periodic in the deflection: {1e3 * length:.2g} mm, {size}")
        meaning = {}
    for c in rest.curves[:3]:
        words = f"its mean over {c.quantity} explains {100 * c.share:.0f} % of it"
        if c.shape:
            words += f" and is {c.shape} in it"
        if (c.quantity, c.shape) in meaning:
            words += f": {meaning[c.quantity, c.shape]}"
        out.append(words)
    for a, b, share in rest.pairs[:1]:
        out.append(
            f"{a} and {b} together explain {100 * share:.0f} % of it, far more than either alone"
        )
    for frequency, amplitude, share in rest.lines:
        size = f"amplitude {amplitude:.2g} N, {100 * share:.0f} % of it"
        out.append(f"it holds a steady tone of {frequency:.3g} Hz, {size}")
    if not out:
        out.append(
            "it depends on no single quantity by its mean: look at the importance of the past and at the map"
        )
    return tuple(out)


def arguments(rest: Rest) -> list[str]:
    """Arguments that the equation of the effect would have."""
    found = [ARGUMENTS[q] for pair in rest.pairs[:1] for q in pair[:2]]
    found += [ARGUMENTS[c.quantity] for c in rest.curves if c.quantity in ARGUMENTS]
    found = found[:2]
    if rest.period:
        found.insert(0, "x")
    if not found and rest.lines:
        found.append("t")
    return list(dict.fromkeys(found)) or ["v", "x"]


def skeleton(rest: Mapping[str, Any]) -> str:
    """The beginning of an effect's file, with what was found as its starts; the equation is the user's to change."""
    own, names, force, params = _equation(rest)
    arguments_ = ", ".join(f"{a}: float" for a in [*own, *names])
    lines = "\n".join(f"        {p}," for p in params)
    return f'''"""What this is."""

import math

from er_models.effect import Effect, Param, Signature


def force({arguments_}) -> float:
    """Force it adds [N]."""
    return {force}


EFFECT = Effect(
    name="my_effect", stage="force", title="My effect", physics="Why it is there.",
    # name, unit, lower and upper bound, neutral value, starts: multiples of the natural scale of the unit
    parameters=(
{lines}
    ),
    hooks={{"force": force}},
    signature=Signature("how it shows", "force-velocity", "what shows it best"),
    source="where it comes from",
)
'''


def _equation(rest: Mapping[str, Any]) -> tuple[list[str], list[str], str, list[str]]:
    """Parameters, arguments, the force, and the declarations of the parameters."""
    size, length = rest["scales"]
    period, names = rest["period"], list(rest["arguments"])
    if period:
        p = period["length"] / length
        wave = f'Param("p", "m", {0.3 * p:.3g}, {3.0 * p:.3g}, None, ({p:.4g},), "period")'
        force = "A * math.sin(2.0 * math.pi * x / p + phi)"
        return ["A", "p", "phi"], ["x"], force, _wave(period["amplitude"] / size, wave)
    if names == ["t"] and rest["lines"]:
        line = rest["lines"][0]
        f = line["frequency"]
        wave = f'Param("f", "1/s", {0.99 * f:.5g}, {1.01 * f:.5g}, None, ({f:.6g},), "frequency")'
        force = "A * math.sin(2.0 * math.pi * f * t + phi)"
        return ["A", "f", "phi"], ["t"], force, _wave(line["amplitude"] / size, wave)
    unit = UNITS.get("".join(sorted(names)), "N")
    param = f'Param("K", "{unit}", -10.0, 10.0, 0.0, (0.1, -0.1), "to be named")'
    return ["K"], names, f"K * {' * '.join(names)}", [param]


def _wave(amplitude: float, length: str) -> list[str]:
    """Declarations of a wave: its amplitude over the scale of the force, its length, its phase."""
    return [
        f'Param("A", "N", -1.0, 1.0, 0.0, ({amplitude:.2g}, {-amplitude:.2g}), "amplitude")', length,
        'Param("phi", "1", -3.2, 3.2, None, (0.0, 1.6), "phase")',
    ]  # fmt: skip
