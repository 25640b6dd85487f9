"""The comparison as tables: means over the roads, and paired differences with their intervals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from er_studies.control.measures import NAMES, Measures
from er_studies.control.run import Outcome
from er_studies.control.scenarios import Scenario

OURS = "fault_tolerant"
LEVEL = 0.95
_HEADS = (
    "deflection rms [mm]",
    "peak [mm]",
    "comfort [m/s2]",
    "tyre load [N]",
    "violations",
    "wishes",
    "safe",
)
_FACTORS = (1e3, 1e3, 1.0, 1.0)


class Paired(NamedTuple):
    """Difference of two controllers on the same roads over the mean of the second; half its interval, NaN: one road."""

    mean: float
    half: float

    @property
    def words(self) -> str:
        """In per cent."""
        if math.isnan(self.half):
            return f"{100 * self.mean:+.1f} %"
        return f"{100 * self.mean:+.1f} ± {100 * self.half:.1f} %"


def paired(outcomes: Sequence[Outcome], measure: str, one: str, other: str) -> Paired:
    """Relative difference of two controllers in a measure, road by road, of outcomes of one scenario and fault."""
    values = {
        law: np.array([getattr(o.measures, measure) for o in outcomes if o.law == law])
        for law in (one, other)
    }
    gap, size = values[one] - values[other], float(values[other].mean())
    n = gap.size
    if n < 2:
        return Paired(float(gap.mean()) / size, math.nan)
    half = float(stdtrit(n - 1, 0.5 + 0.5 * LEVEL) * gap.std(ddof=1) / math.sqrt(n))
    return Paired(float(gap.mean()) / size, half / size)


def of(outcomes: Sequence[Outcome], scenario: str, fault: str) -> list[Outcome]:
    """Outcomes of one scenario and fault."""
    return [o for o in outcomes if (o.scenario, o.fault) == (scenario, fault)]


def means(outcomes: Sequence[Outcome], law: str) -> Measures:
    """Mean measures of a controller; the peak is the mean of the roads' peaks."""
    mine = [o.measures for o in outcomes if o.law == law]
    return Measures(*(float(np.mean([getattr(m, f) for m in mine])) for f in Measures._fields))


def markdown(scenarios: Sequence[Scenario], outcomes: Sequence[Outcome], source: str) -> str:
    """Tables of all scenarios; source: where the controllers have the faults from."""
    return "\n".join(line for s in scenarios for line in _scenario(s, outcomes, source))


def _scenario(s: Scenario, outcomes: Sequence[Outcome], source: str) -> list[str]:
    """One scenario: every fault and controller, then what ours changes."""
    mine = [o for o in outcomes if o.scenario == s.name]
    roads = len({o.number for o in mine})
    begin, end = s.window
    lines = [
        f"### {s.name}, faults {source}: {s.title}", "",
        f"{roads} road{'s' if roads > 1 else ''}, {begin:g} to {end:g} s, duty to {s.duty_max:g}, "
        f"latency {s.latency} samples.", "",
        f"| fault | controller | {' | '.join(_HEADS)} |",
        f"|---|---|{'---|' * len(_HEADS)}",
    ]  # fmt: skip
    for fault in s.faults:
        these = of(mine, s.name, fault)
        for law in dict.fromkeys(o.law for o in these):
            m = means(these, law)
            cells = [f"{getattr(m, n) * k:.3f}" for n, k in zip(NAMES, _FACTORS, strict=True)]
            cells += [_share(m.violations), _share(m.wishes), _share(m.safe)]
            lines.append(f"| {fault} | {law} | {' | '.join(cells)} |")
    return [*lines, "", *_differences(s, mine), ""]


def _differences(s: Scenario, mine: Sequence[Outcome]) -> list[str]:
    """Ours minus each other controller, paired."""
    lines = [
        f"Fault-tolerant minus the other, share of the other, mean and {100 * LEVEL:g} % interval over the roads:", "",
        f"| fault | against | {' | '.join(_HEADS[:4])} |", "|---|---|---|---|---|---|",
    ]  # fmt: skip
    for fault in s.faults:
        these = of(mine, s.name, fault)
        for other in dict.fromkeys(o.law for o in these if o.law != OURS):
            cells = [paired(these, n, OURS, other).words for n in NAMES]
            lines.append(f"| {fault} | {other} | {' | '.join(cells)} |")
    return lines


def _share(value: float) -> str:
    """A share in per cent; 0 is exactly none, - says that there is nothing to count."""
    if math.isnan(value):
        return "-"
    return "0" if value == 0.0 else f"{100 * value:.2g} %"
