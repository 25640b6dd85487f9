"""What an identification has to say in words: what is missing in the data, what is weak, what contradicts."""

from __future__ import annotations

from typing import Literal

import numpy as np
from er_models.model import Model

from er_model_lab.identification.law import response_time
from er_model_lab.identification.procedure import Identified
from er_model_lab.identification.visibility import CHANGE, TIED
from er_model_lab.output.text.units import newtons, percent, short
from er_model_lab.output.text.verdict_text import joined

Verdict = Literal["identified", "identified_in_part"]
"""Whether the data say every parameter that was to be found."""
PARTNER = 0.8
"""Correlation from which a weak parameter's closest companion is named."""
BEYOND = 1.5
"""Residual over the white noise of the force from which the model is said to leave too much."""
SURE = 4.0
"""Standard deviations from which a difference is real."""


def verdict(found: Identified) -> Verdict:
    """One word for the result."""
    return "identified_in_part" if found.held else "identified"


def missing(found: Identified) -> list[str]:
    """What the data lack for the stages the model needs, and which parameters therefore keep their values."""
    out = [s.left_out for s in found.stages if s.left_out and s.needed]
    duties = [level.duty for level in found.levels if level.duty > 0.0]
    if len(duties) == 1 and found.stages[1].done:
        out.append(
            f"one duty only ({short(duties[0])}): how the yield force and its response time change "
            "with the duty rests on the form of the model"
        )
    for q, others in found.refined.taken_up.items():
        value, unit = found.model.value(*q), unit_of(found.model, *q)
        for_it = (
            f"; valid for that value only: {joined(['.'.join(o) for o in others])}"
            if others
            else ""
        )
        kept = np.isclose(value, found.before.value(*q), rtol=1e-6)
        whose = (
            "keeps the value of the given model" if kept else "has a value of the size of the data"
        )
        out.append(
            f"{'.'.join(q)} {whose}, {f'{short(value, 4)} {unit}'.strip()}: "
            f"these data do not say it{for_it}"
        )
    return out


def findings(found: Identified) -> list[str]:
    """What a user should know before trusting the values, most important first."""
    return [*_leaves(found), *_offset(found), *_edges(found), *_weak(found), *_tied(found),
            *_law(found), *_steps(found), *_lag(found)]  # fmt: skip


def unit_of(model: Model, effect: str, name: str) -> str:
    """Unit of a parameter; empty for pure numbers."""
    unit = model.catalogue[effect].parameter(name).unit
    return "" if unit == "1" else unit


def _leaves(found: Identified) -> list[str]:
    """Whether the model leaves more than the noise of the force."""
    left, white = found.refined.visibility.noise, found.problem.sd_force
    if left < BEYOND * white:
        return []
    return [
        f"the model leaves {newtons(left)} where the white noise of the force is {newtons(white)}: the values are "
        "those of a model that lacks something; `lab diagnose` says what"
    ]


def _offset(found: Identified) -> list[str]:
    """A mean that the residual keeps, which no parameter of the model can take."""
    r = found.residual[found.problem.train]
    length = max(round(1.0 / found.problem.motion.dt), 1)
    means = np.array([b.mean() for b in np.array_split(r, max(r.size // length, 2))])
    mean, sd = float(r.mean()), float(means.std(ddof=1) / np.sqrt(means.size))
    if abs(mean) < SURE * sd or abs(mean) < CHANGE * found.refined.visibility.noise:
        return []
    return [
        f"the residual has a mean of {newtons(mean)}: an offset of the force; `lab add preload` takes it"
    ]


def _edges(found: Identified) -> list[str]:
    """Parameters at their bounds."""
    fit = found.refined.fit
    return [
        f"{e}.{n} is at its bound {short(found.model.value(e, n))} {unit_of(found.model, e, n)}: "
        "the data would rather have it beyond"
        for (e, n), edge in zip(fit.free, fit.at_bound, strict=True)
        if edge
    ]


def _weak(found: Identified) -> list[str]:
    """Parameters that hardly change the force, in one sentence."""
    seen, free = found.refined.visibility, found.refined.fit.free
    weak = [i for i in range(len(free)) if seen.weak[i] and not found.refined.fit.at_bound[i]]
    if not weak:
        return []
    each = [
        f"{'.'.join(free[i])} ({newtons(seen.visible[i])}{_companion(found, i)})" for i in weak
    ]
    return [
        f"weakly visible, {percent(CHANGE)} of the value changes the force by no more than this once the others "
        f"adjust, and {newtons(seen.noise)} are left anyway: {joined(each)}"
    ]


def _companion(found: Identified, i: int) -> str:
    """What a weak parameter moves with, as the end of a clause."""
    seen = found.refined.visibility
    row = np.nan_to_num(np.abs(seen.correlation[i]))
    row[i] = 0.0
    k = int(np.argmax(row))
    if row[k] <= PARTNER:
        return ""
    return f"; moves with {'.'.join(found.refined.fit.free[k])}, correlation {seen.correlation[i, k]:.2f}"


def _tied(found: Identified) -> list[str]:
    """Pairs that are visible each, but hardly apart."""
    seen, free = found.refined.visibility, found.refined.fit.free
    pairs = [
        (i, k)
        for i in range(len(free))
        for k in range(i)
        if abs(np.nan_to_num(seen.correlation[i, k])) > TIED and not (seen.weak[i] or seen.weak[k])
    ]
    return [
        f"{'.'.join(free[k])} and {'.'.join(free[i])} are hardly told apart (correlation {seen.correlation[i, k]:.2f})"
        for i, k in pairs
    ]


def _law(found: Identified) -> list[str]:
    """Whether the response time of the model follows the response times of the levels."""
    table = found.table
    if table is None or table.duty.size < 2:
        return []
    away = table.tau - response_time(found.model, table.duty)
    worst = int(np.argmax(np.abs(away)))
    sd = float(table.sd[worst])
    if not abs(away[worst]) > max(SURE * sd, CHANGE * table.tau[worst]):
        return []
    return [
        f"at duty {short(float(table.duty[worst]))} the response time is {1e3 * table.tau[worst]:.1f} +- "
        f"{1e3 * sd:.1f} ms, {1e3 * abs(away[worst]):.1f} ms off the model's law: a model with another tau(u) "
        "would follow it"
    ]


def _steps(found: Identified) -> list[str]:
    """Whether the duty ever changes while the damper moves."""
    m = found.problem.motion
    inner = np.ones(m.n, bool)
    inner[m.starts[:-1]] = False
    changes = np.abs(np.diff(m.u, prepend=m.u[0])) > 0.0
    if found.table is None or np.any(changes & inner):
        return []
    return [
        "the duty never steps: the response time rests on the turning points of the motion alone"
    ]


def _lag(found: Identified) -> list[str]:
    """What was done about a lagging velocity channel."""
    if found.lag is None:
        return []
    lag, sd = found.lag
    return [
        f"the velocity channel lags deflection by {1e3 * lag:.2f} +- {1e3 * sd:.2f} ms; this was undone first"
    ]
