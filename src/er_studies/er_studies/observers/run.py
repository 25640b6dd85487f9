"""Runs estimators on scenarios: one record per road, every estimator on it, errors per window."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
from er_models.model import Array, Model
from er_models.orphan import end_with_parent
from er_models.parallel import cores
from er_observers.observers.status import Status
from er_observers.running.runtime import Estimate, Sample

from er_studies.observers.estimators import Estimator, estimators_of, gains_alone
from er_studies.observers.floor import floor_of
from er_studies.observers.nrmse import SETTLED, nrmse, settling_time
from er_studies.observers.scenarios.drive import drive
from er_studies.observers.scenarios.scenario import Plant, Scenario
from er_studies.observers.scenarios.starts import first_state

_TOLD = (
    "t",
    "told_sprung_acceleration",
    "told_unsprung_acceleration",
    "told_duty",
    "told_deflection",
)


class Trace(NamedTuple):
    """An estimator along a record: force (n,) [N], status (n,)."""

    force: Array
    status: Array


class Outcome(NamedTuple):
    """One estimator on one road.

    errors: NRMSE of each window of the scenario; settled: `settling_time` [s]; unnoticed: share
    of the samples that are wrong by more than 2 % of the range and called OK; floors: `floor.floor_of`
    of each window, where plant or sensors are not what is believed; alone: as errors, of the proved gain
    without start phase, where there is one.
    """

    scenario: str
    number: int
    estimator: str
    errors: tuple[float, ...]
    settled: float
    unnoticed: float
    floors: tuple[float, ...] = ()
    alone: tuple[float, ...] = ()


def follow(estimator: Estimator, record: dict[str, Array], x: Array | None) -> Trace:
    """The estimator along a record of `drive`, from the first state x (n,) or its own."""
    rows = zip(*(record[name].tolist() for name in _TOLD), strict=True)
    samples = [Sample(*row) for row in rows]
    p, step = estimator.parameters, estimator.step
    state = estimator.start(p, samples[0], x)
    estimates: list[Estimate] = [state.estimate]
    for sample in samples[1:]:
        state, estimate = step(p, state, sample)
        estimates.append(estimate)
    force = np.array([e.force for e in estimates])
    return Trace(force, np.array([int(e.status) for e in estimates]))


def road_outcomes(
    scenario: Scenario, number: int, model: Model, estimators: Sequence[Estimator]
) -> list[Outcome]:
    """Every estimator on road `number` of a scenario."""
    record = drive(scenario, model, number)
    wrong = scenario.plant != Plant() or scenario.sensors.delay > 0.0
    windows = scenario.windows if wrong else ()
    floors = tuple(floor_of(scenario, w, record, model) for w in windows)
    outcomes = []
    for e in estimators:
        x, bare = first_state(scenario, e.form, e.name, record, number), gains_alone(e)
        found = _outcome(scenario, number, e.name, record, follow(e, record, x))
        alone = () if bare is None else _errors(scenario, record, follow(bare, record, x))
        outcomes.append(found._replace(floors=floors, alone=alone))
    return outcomes


def _errors(scenario: Scenario, record: dict[str, Array], trace: Trace) -> tuple[float, ...]:
    """NRMSE of each window."""
    t, true, errors = record["t"], record["damper_force"], []
    for window in scenario.windows:
        rows = (t >= window.begin - 1e-9) & (t <= window.end + 1e-9)
        errors.append(nrmse(true[rows], trace.force[rows]))
    return tuple(errors)


def _outcome(
    scenario: Scenario, number: int, name: str, record: dict[str, Array], trace: Trace
) -> Outcome:
    """The figures of one run."""
    t, true = record["t"], record["damper_force"]
    wrong = np.abs(trace.force - true) > SETTLED * float(np.ptp(true))
    return Outcome(
        scenario.name, number, name, _errors(scenario, record, trace),
        settled=settling_time(t, true, trace.force),
        unnoticed=float(np.mean(wrong & (trace.status == int(Status.OK)))),
    )  # fmt: skip


class _Job(NamedTuple):
    """A road that a worker drives."""

    scenario: Scenario
    number: int


_WORKER: dict[str, tuple[Model, tuple[Estimator, ...]]] = {}


def _prepare_worker(model: Model, gains: Path) -> None:
    """What a worker keeps between roads."""
    _WORKER["here"] = (model, estimators_of(model, gains))


def _begin_worker(model: Model, gains: Path) -> None:
    """A worker of its own process, which ends with the one that started it."""
    end_with_parent()
    _prepare_worker(model, gains)


def _work(job: _Job) -> list[Outcome]:
    """One road in a worker."""
    model, estimators = _WORKER["here"]
    return road_outcomes(job.scenario, job.number, model, estimators)


def compare(
    scenarios: Sequence[Scenario],
    model: Model,
    gains: Path,
    seeds: int | None = None,
    tick: Callable[[int, int], None] | None = None,
) -> list[Outcome]:
    """All scenarios on all their roads, or the first `seeds` of each, spread over the cores.

    tick: called with the number of roads done and of all.
    """
    jobs = [_Job(s, k) for s in scenarios for k in range(min(s.seeds, seeds or s.seeds))]
    found: list[Outcome] = []
    for done, outcomes in enumerate(_spread(jobs, model, gains), start=1):
        found += outcomes
        if tick is not None:
            tick(done, len(jobs))
    return found


def _spread(jobs: list[_Job], model: Model, gains: Path) -> Iterator[list[Outcome]]:
    """Outcomes of all jobs in order: here when they are few, else in one process a core."""
    if len(jobs) < 4 or cores() < 2:
        _prepare_worker(model, gains)
        yield from map(_work, jobs)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(cores(), context, _begin_worker, (model, gains)) as pool:
        yield from pool.map(_work, jobs)
