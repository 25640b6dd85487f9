"""What a model was fitted to: the reach of its data, kept in its history, and how far other data go beyond it.

Forms that agree where the data were may differ anywhere else, and nothing in the data says which of them is right.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from er_models.effect import arguments
from er_models.model import Array, Model
from numpy.typing import NDArray

from er_model_lab.problem.problem import Problem

REACH = "reach"
"""Key in an entry of a model's history."""
GAP = "duty_gap"
"""Key in a reach: a range of the duty, within its ends, of which there was none."""
TENTHS, WIDE = 10, 5
"""Parts of the duty's range, and how many of them in a row without samples are a gap: with three levels that lie evenly
a law of the duty shows its bend, with two it does not."""
MARGIN = 0.1
"""Share of a reach by which data may pass its ends: as much as two records of one road differ."""
HEAT = 1.5
"""Factor of a record's mean power that counts as more heat than was there."""
FEW, LITTLE = 0.01, 0.05
"""Share of the samples, and of the squared error, below which there is nothing to say."""
LARGER = 1.3
"""Ratio of the errors beyond what was learnt from and within it from which the one is told."""
_SHOWN = {
    "deflection": (1e3, "mm"),
    "velocity": (1.0, "m/s"),
    "duty": (1.0, ""),
    "power": (1.0, "W"),
}


@dataclass(frozen=True)
class Beyond:
    """Scored samples whose motion or duty lies beyond what a model was fitted to.

    share: of the samples; of_error: of the squared error; rms_inside, rms_beyond: errors [N], nan where there are no
    such samples; reach: `(from, to)` of the data and of what was fitted to [SI], of each quantity that goes beyond,
    the power of whole records among them; of `duty_gap` the second is a range in which no duty was.
    """

    share: float
    of_error: float
    rms_inside: float
    rms_beyond: float
    reach: Mapping[str, tuple[tuple[float, float], tuple[float, float]]]

    @property
    def matters(self) -> bool:
        """Whether there is something to say."""
        return self.share >= FEW or self.of_error >= LITTLE or "power" in self.reach

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        reach = {k: {"data": list(d), "fitted": list(f)} for k, (d, f) in self.reach.items()}
        return {
            "share": self.share, "of_error": self.of_error, "rms_inside": self.rms_inside,
            "rms_beyond": self.rms_beyond, "reach": reach,
        }  # fmt: skip

    def note(self, data: str, fitted: str) -> str:
        """In words; data: which go beyond; fitted: what."""
        parts = "; ".join(_ranges(k, *ranges) for k, ranges in self.reach.items())
        said = f"{data} go beyond {fitted} ({parts})"
        if not self.share:
            return said
        rest = f" and {self.rms_inside:.3g} N elsewhere" if self.share < 1.0 else ""
        return f"{said}: {self.share:.0%} of the samples, with an error of {self.rms_beyond:.3g} N there{rest}"


def reach(problem: Problem) -> dict[str, Any]:
    """Ends of deflection [m], velocity [m/s], duty [1] and a record's mean power [W] over the training samples.

    Where the duty has a gap between its ends, the gap's ends besides (`GAP`).
    """
    seen = {k: y[problem.train] for k, y in _samples(problem).items()}
    ends: dict[str, Any] = {k: [float(y.min()), float(y.max())] for k, y in seen.items()}
    gap = duty_gap(seen["duty"])
    return ends | ({GAP: list(gap)} if gap else {})


def duty_gap(duty: Array) -> tuple[float, float] | None:
    """A wide range between the ends of duties (n,) in which hardly any of them lies; None where there is none."""
    low, high = float(duty.min()), float(duty.max())
    if not high > low:
        return None
    counts, ends = np.histogram(duty, TENTHS, (low, high))
    empty = "".join("01"[int(n < FEW * duty.size)] for n in counts)
    run = re.search(f"1{{{WIDE},}}", empty)
    return (float(ends[run.start()]), float(ends[run.end()])) if run else None


def gap_note(model: Model, problem: Problem) -> tuple[str, ...]:
    """What is said of a model that answers to the duty, where the training samples leave a gap of it."""
    gap = duty_gap(problem.motion.u[problem.train])
    hooks = [hook for e in model.effects for hook in model.catalogue[e].hooks.values()]
    if gap is None or not any({"u", "u_f"} & {*arguments(hook)} for hook in hooks):
        return ()
    low, high = gap
    return (
        f"the duty is hardly ever between {low:.2g} and {high:.2g} where the model was fitted: the force at such "
        "duties rests on the form of the model",
    )


def beyond(model: Model, problem: Problem, residual: Array) -> Beyond | None:
    """How far data go beyond what the model was fitted to; residual (n,) of the model as it is [N].

    None where its history does not say (a model that was never fitted here), or nothing goes beyond.
    """
    fitted = next((e[REACH] for e in reversed(model.history) if REACH in e), None)
    return None if fitted is None else _beyond(problem, residual, fitted, problem.used)


def held_out_beyond(problem: Problem, residual: Array) -> Beyond | None:
    """How far the held-out samples go beyond those learnt from, where the error there is larger than elsewhere."""
    found = _beyond(problem, residual, reach(problem), problem.held_out)
    return found if found and found.rms_beyond > LARGER * found.rms_inside else None


def within_learnt(problem: Problem) -> NDArray[np.bool_]:
    """Held-out samples (n,) whose motion and duty lie within the reach of those learnt from."""
    outside = [
        mask for k, mask in _outside(_samples(problem), reach(problem)).items() if k != "power"
    ]
    return np.asarray(problem.held_out & ~np.logical_or.reduce(outside))


def _beyond(
    problem: Problem, residual: Array, fitted: Mapping[str, Any], rows: NDArray[np.bool_]
) -> Beyond | None:
    """How far the samples of a mask (n,) go beyond the ends of what was fitted to."""
    outside, samples = np.zeros(problem.force.size, dtype=bool), _samples(problem)
    further = {}
    for name, mask in _outside(samples, fitted).items():
        here = rows & mask
        # a level that is left passes through the gap
        if here.sum() >= (FEW * rows.sum() if name == GAP else 1):
            seen = samples["duty"][here] if name == GAP else samples[name][rows]
            low, high = fitted[name]
            further[name] = ((float(seen.min()), float(seen.max())), (float(low), float(high)))
            outside |= here & (name != "power")
    if not further:
        return None
    square, inside = residual**2, rows & ~outside
    return Beyond(
        float(outside.sum() / rows.sum()),
        float(square[outside].sum() / max(square[rows].sum(), 1e-300)),
        _rms(square, inside), _rms(square, outside), further,
    )  # fmt: skip


def _samples(problem: Problem) -> dict[str, Array]:
    """Each quantity at every sample; the power is the mean of its record."""
    m, power = problem.motion, np.abs(problem.force * problem.motion.v)
    mean = np.concatenate(
        [np.full(j - i, power[i:j].mean()) for i, j in itertools.pairwise(m.starts)]
    )
    return {"deflection": m.x, "velocity": m.v, "duty": m.u, "power": mean}


def _outside(
    samples: Mapping[str, Array], fitted: Mapping[str, Any]
) -> dict[str, NDArray[np.bool_]]:
    """Samples (n,) beyond a reach, by quantity, and those in a gap: less power than before is nothing new."""
    found = {}
    for name, y in samples.items():
        low, high = fitted[name]
        margin = MARGIN * (high - low)
        power = name == "power"
        found[name] = y > HEAT * high if power else (y < low - margin) | (y > high + margin)
    if GAP in fitted:
        low, high = fitted[GAP]
        found[GAP] = (samples["duty"] > low) & (samples["duty"] < high)
    return found


def _rms(square: Array, mask: NDArray[np.bool_]) -> float:
    return float(np.sqrt(np.mean(square[mask]))) if mask.any() else float("nan")


def _ranges(name: str, data: tuple[float, float], fitted: tuple[float, float]) -> str:
    """`deflection -22 to 23 mm, fitted to -3.4 to 3.3 mm`."""
    if name == GAP:
        ends = " to ".join(dict.fromkeys(f"{u:.2g}" for u in data))
        return f"duty {ends}, fitted to none between {fitted[0]:.2g} and {fitted[1]:.2g}"
    scale, unit = _SHOWN[name]

    def words(ends: tuple[float, float]) -> str:
        low, high = (scale * e for e in ends)
        said = f"up to {high:.2g}" if name == "power" else f"{low:.2g} to {high:.2g}"
        return f"{said} {unit}".rstrip()

    return f"{name} {words(data)}, fitted to {words(fitted)}"
