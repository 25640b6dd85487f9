"""Is the fault estimator good enough? Random drives with faults, without, with hidden effects; counts, not opinions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array, Model
from er_observers.faults.estimator import start, step
from er_observers.faults.rules import Estimator
from er_observers.faults.sample import Estimate, FactorStatus, Kind

from er_studies.faults import bound
from er_studies.faults.trials import FAULTS, Drive, Trial, drive

NAMED = {"f1": Kind.ELECTRICAL, "f2": Kind.LEAKAGE, "f3": Kind.DEFORMATION}
LIMITS = {"f1": (0.1, 5.0), "f2": (0.05, 2.0), "f3": (0.1, 5.0)}
"""Error of a factor, and after how many seconds of motion it may be no larger."""
EXCITED = 0.95
"""A fault is excited where the best estimator, not told which it is, would be within the limits this probably."""
_MOVING, _LOOK = 0.07, 50


class Outcome(NamedTuple):
    """Of one drive with a fault.

    errors: of each factor, at the time of `LIMITS`; could: probability that the best unbiased estimator has all of them
    within the limits when it is told which factors have changed, and when it is not, and that the best rule names the
    fault after 5 s; kind: after 5 s of motion; named: when it was first named rightly [s of motion], inf if never;
    wrong: whether another fault was ever named after it, early: whether any was before.
    """

    left: Mapping[str, float]
    errors: Mapping[str, float]
    could: tuple[float, float, float]
    kind: Kind
    named: float
    wrong: bool
    early: bool
    unexplained: bool


def follow(p: Estimator, record: Drive) -> list[Estimate]:
    """Every estimate along a drive."""
    state = start(p, record.samples[0])
    found = [state.estimate]
    for sample in record.samples[1:]:
        state, estimate = step(p, state, sample)
        found.append(estimate)
    return found


def faulty(p: Estimator, trial: Trial, model: Model) -> Outcome:
    """What is made of a fault."""
    record = drive(trial, model)
    found, begun = follow(p, record), round(trial.fault_time / DT)
    moved = np.cumsum(moving(record, model)[begun:]) * DT
    at = {s: begun + min(int(np.searchsorted(moved, s)), moved.size - 1) for s in (2.0, 5.0)}
    errors = {
        f: found[at[LIMITS[f][1]]].factors[int(f[1]) - 1] - left for f, left in trial.left.items()
    }
    right = NAMED[next(iter(trial.left))] if len(trial.left) == 1 else Kind.COMBINED
    hits = [k for k in range(begun, len(found)) if found[k].kind is right]
    after = {e.kind for e in found[begun : at[5.0] + 1]}
    return Outcome(
        trial.left, errors, _could(p, record, trial, begun, at), found[at[5.0]].kind,
        float(moved[hits[0] - begun]) if hits else np.inf,
        bool(after - {right, Kind.NONE, Kind.SOME, Kind.UNKNOWN}),
        any(e.kind > Kind.NONE for e in found[:begun]), found[at[5.0]].unexplained,
    )  # fmt: skip


def _could(
    p: Estimator, record: Drive, trial: Trial, begun: int, at: Mapping[float, int]
) -> tuple[float, float, float]:
    """`Outcome.could`, by the Cramer-Rao bound."""
    times = sorted(at)
    news = tuple(trial.left), bound.NAMES
    least = bound.covariances(p, record, trial.left, news, begun, [at[s] for s in times])
    spread = np.sqrt(np.diagonal(least, axis1=2, axis2=3))
    told, not_told = (
        math.prod(
            bound.chance(each[times.index(LIMITS[f][1]), bound.NAMES.index(f)], LIMITS[f][0])
            for f in trial.left
        )
        for each in spread
    )
    return told, not_told, bound.told_apart(least[1, -1], trial.left)


def moving(record: Drive, model: Model) -> Array:
    """1 where the damper has moved within the last quarter of a second, (n,)."""
    limit = _MOVING * model.rig.get("velocity_max", model.scales.velocity)
    fast = np.abs(record.motion[:, 1]) > limit
    return np.asarray(np.convolve(fast, np.ones(_LOOK))[: fast.size] > 0.0, float)


class Quiet(NamedTuple):
    """Of one drive without a fault: kinds of fault that were named, and those named while nothing was unexplained."""

    name: str
    named: tuple[str, ...]
    silent: tuple[str, ...]
    unexplained: bool
    unexcited: tuple[bool, bool, bool]


def faultless(p: Estimator, trial: Trial, model: Model, name: str = "") -> Quiet:
    """What is made of a damper that has none."""
    found = follow(p, drive(trial, model))
    named = {e.kind.name for e in found if e.kind > Kind.NONE or e.kind is Kind.SOME}
    silent = {
        e.kind.name
        for e in found
        if (e.kind > Kind.NONE or e.kind is Kind.SOME) and not e.unexplained
    }
    lost = [s is FactorStatus.NOT_EXCITED for s in found[-1].states]
    return Quiet(
        name, tuple(sorted(named)), tuple(sorted(silent)), any(e.unexplained for e in found),
        (lost[0], lost[1], lost[2]),
    )  # fmt: skip


def hidden_trials(model: Model, seed: int, number: int) -> Iterator[tuple[str, Trial]]:
    """Every effect of the catalogue that the model has not and a car can show, from the start of a drive on."""
    stages = ("force", "actuation", "heat", "vehicle")
    for effect in model.catalogue.effects:
        if effect.stage in stages and effect.name not in model.effects:
            for i in range(number):
                where = Trial(
                    seed * 1000 + i, hidden={effect.name: {}}, duration=12.0, road="iso8608"
                )
                yield effect.name, where


def healthy_trials(seed: int, number: int) -> Iterator[Trial]:
    """Dampers whose parameters are off by up to 5 %."""
    for i in range(number):
        yield Trial(seed * 1000 + 500 + i, spread=0.05, duration=12.0)


def kinds() -> tuple[str, ...]:
    """What `trials.faults` can draw."""
    return (*FAULTS, "combined")
