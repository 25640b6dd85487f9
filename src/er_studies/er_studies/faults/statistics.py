"""Hundreds of drives on continuous roads of every kind: what the fault estimator names, and what it leaves open."""

from __future__ import annotations

import math
import multiprocessing
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Model
from er_models.orphan import end_with_parent
from er_models.parallel import cores
from er_observers.faults.ready import ready
from er_observers.faults.rules import Estimator
from er_observers.faults.sample import Kind

from er_studies.faults.acceptance import NAMED, follow, moving
from er_studies.faults.trials import COURSES, Trial, drive

SPREAD = 0.05
"""Share by which every parameter of every car is off."""
PEAKS = (0.05, 0.3)
"""Least and greatest peak of the deflection velocity [m/s]."""
CLOSE, IN_TIME = 0.02, 10.0
"""Error of a factor that is right, and the motion after which a fault has to be named [s]."""
LEARNT = 3.0
"""Motion [s] of the healthy damper after which a change is a change: without it a fault is there from the start."""
_QUIET = tuple(COURSES[:5]) + COURSES
"""Roads of drives without a fault in turn: 10 of 14 of ISO 8608."""


@dataclass(frozen=True)
class Group:
    """Drives of one kind.

    left: what the fault leaves; from_start: it is there from the first sample on, else it appears after 6 to 10 s;
    grows: see `Trial`; hidden: what the model does not know; seconds: length of a drive.
    """

    name: str
    left: Mapping[str, float] = field(default_factory=dict)
    from_start: bool = False
    grows: float = 0.0
    hidden: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    seconds: float = 60.0


HEALTHY = (
    Group("healthy"),
    Group("friction 0.5 N", hidden={"coulomb_friction": {"F_c": 0.5, "v_0": 0.003}}),
    Group("mass +20 %", hidden={"sprung_mass_error": {"e": 0.2}}),
)
FAULTY = (
    Group("f1 = 0.5", {"f1": 0.5}, seconds=30.0),
    Group("f2 = 0.6", {"f2": 0.6}, seconds=30.0),
    Group("f3 = 0.6", {"f3": 0.6}, seconds=30.0),
    Group("f2 = 0.8", {"f2": 0.8}, seconds=30.0),
    Group("f1 = 0.5, f2 = 0.6", {"f1": 0.5, "f2": 0.6}, seconds=30.0),
    Group("f2 = f3 = 0.6", {"f2": 0.6, "f3": 0.6}, seconds=30.0),
    Group("f2 = 0.6, growing for 10 s", {"f2": 0.6}, grows=10.0, seconds=40.0),
    Group("f2 = 0.6 from the start", {"f2": 0.6}, from_start=True, seconds=30.0),
)
GROUPS = (*HEALTHY, *FAULTY)


class Found(NamedTuple):
    """Of one drive.

    wrong: kinds of fault that were named and are not there; unexplained: share of the time; named: motion until the
    fault had its name [s], inf without; error: greatest of its factors after `IN_TIME` s of motion, and at the end;
    moved: motion after the fault [s]; last: the kind at the end; doubted: whether something is unexplained then;
    left_open: whether a fault was ever said to be there whose kind is open; moved_before: motion before the fault [s].
    """

    road: str
    wrong: tuple[str, ...]
    unexplained: float
    named: float
    error: float
    last_error: float
    moved: float
    last: str
    doubted: bool
    left_open: bool
    moved_before: float


def trial_of(group: Group, seed: int, number: int) -> Trial:
    """Drive `number` of a group: road in turn, speed, peak and duty at random; one in four has a constant duty."""
    random = np.random.default_rng([seed, number, 7])
    roads = COURSES if group.left else _QUIET
    peak = math.exp(random.uniform(*np.log(PEAKS)))
    begun = float(random.uniform(6.0, 10.0))
    held = float(random.uniform(0.1, 0.3)) if random.random() < 0.25 else None
    return Trial(
        seed * 100_000 + number, group.left, -1.0 if group.from_start else begun, group.seconds, group.hidden, SPREAD,
        held, road=roads[number % len(roads)], peak=peak, grows=group.grows,
    )  # fmt: skip


def found_in(trial: Trial, model: Model, p: Estimator) -> Found:
    """What the estimator makes of a drive."""
    record = drive(trial, model)
    said = follow(p, record)
    appears, begun = (
        max(round(t / DT), 0) for t in (trial.fault_time, trial.fault_time + trial.grows)
    )
    motion = moving(record, model)
    moved = np.cumsum(motion[begun:]) * DT
    right = NAMED[next(iter(trial.left))] if len(trial.left) == 1 else Kind.COMBINED
    right = right if trial.left else Kind.NONE
    others = {
        e.kind.name for e in said if e.kind not in (right, Kind.NONE, Kind.SOME, Kind.UNKNOWN)
    }
    early = {e.kind.name for e in said[:appears] if e.kind > Kind.NONE}
    hits = [k for k in range(begun, len(said)) if said[k].kind is right]
    then = begun + min(int(np.searchsorted(moved, IN_TIME)), moved.size - 1)
    error, last_error = (
        max((abs(said[k].factors[int(f[1]) - 1] - v) for f, v in trial.left.items()), default=0.0)
        for k in (then, -1)
    )
    return Found(
        trial.road, tuple(sorted(others | early)), float(np.mean([e.unexplained for e in said])),
        float(moved[hits[0] - begun]) if hits else math.inf, error, last_error, float(moved[-1]), said[-1].kind.name,
        said[-1].unexplained, any(e.kind is Kind.SOME for e in said),
        float(motion[:appears].sum()) * DT,
    )  # fmt: skip


_WORKER: dict[str, Any] = {}


def _begin_worker(model: Model) -> None:
    end_with_parent()
    _WORKER["here"] = model, ready(model)


def _work(job: tuple[Group, int, int]) -> Found:
    group, seed, number = job
    model, p = _WORKER["here"]
    return found_in(trial_of(group, seed, number), model, p)


def statistics(
    groups: Sequence[Group],
    model: Model,
    seed: int,
    number: int,
    known: Mapping[str, int] | None = None,
) -> Iterator[tuple[Group, Found]]:
    """Every drive of every group, in order, spread over the cores; known: so many of a group are left out."""
    jobs = [
        (group, seed, i)
        for group in groups
        for i in range((known or {}).get(group.name, 0), number)
    ]
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(cores(), context, _begin_worker, (model,)) as pool:
        yield from zip((job[0] for job in jobs), pool.map(_work, jobs), strict=True)


def plain(found: Mapping[str, Sequence[Found]]) -> dict[str, list[list[Any]]]:
    """Drives as JSON knows them: what was never named has no time."""
    return {
        name: [[None if value == math.inf else value for value in each] for each in drives]
        for name, drives in found.items()
    }


def read(found: Mapping[str, Sequence[Sequence[Any]]]) -> dict[str, list[Found]]:
    """Drives of what `plain` made."""
    return {
        name: [
            Found._make(math.inf if value is None else value for value in each) for each in drives
        ]
        for name, drives in found.items()
    }
