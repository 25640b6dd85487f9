"""One question to one data set: the steps behind `compare`, `diagnose`, `add` and `improve`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from er_models.errors import MissingChannel
from er_models.model import Array, Model
from er_models.predict import Motion

from er_model_lab.diagnosis.candidates import Candidate, baseline, refit
from er_model_lab.diagnosis.noise_floor import Floor, noise_floor
from er_model_lab.diagnosis.null import Null, simulate_null
from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.diagnosis.search import Round, passes, threshold
from er_model_lab.diagnosis.verdict import Diagnosis, diagnose, judge, shares
from er_model_lab.fitting.envelope import with_unfelt
from er_model_lab.fitting.estimate import estimated
from er_model_lab.fitting.fit import fit, with_deviations
from er_model_lab.fitting.velocity_channel import (
    KINEMATIC,
    as_searched,
    in_scale,
    known_lag,
    on_fused,
    put_back,
)
from er_model_lab.long.check import Checked, checked, long_json, long_note
from er_model_lab.long.whole_record import LongForward, on_whole, remembers
from er_model_lab.problem.fit_store import Notes
from er_model_lab.problem.prepare import prepare
from er_model_lab.problem.problem import Problem
from er_model_lab.problem.stretches import with_more
from er_model_lab.records.record import Record
from er_model_lab.vehicle.ride_forward import RideForward
from er_model_lab.vehicle.ride_problem import open_ride
from er_model_lab.work import HERE, Work

SMALLEST_LAG = 0.08
"""Lag of the velocity channel that counts, in samples."""
SURE_LAG = 8.0
"""Standard deviations of a lag from which it is undone: they know of noise alone, and a wrong lag spoils all else."""


@dataclass(frozen=True)
class Study:
    """A diagnosis with the data before and after what the sensors were found to do.

    problem: the one diagnosed; lag: (value, standard deviation) [s] when the velocity channel lags, else
    None; lag_base: the model refitted on the lagging channel; given: residual (n,) of the model exactly
    as given; records: those searched, or stretches of them; checked: the models on all of long data; long: the
    same for the JSON.
    """

    diagnosis: Diagnosis
    problem: Problem
    model: Model
    lag: tuple[float, float] | None
    lag_base: Candidate | None
    given: Array
    records: tuple[Record, ...] = ()
    checked: Checked | None = None
    long: dict[str, Any] | None = None


def open_problem(
    records: list[Record],
    model: Model,
    sealed: int = 0,
    *,
    any_lag: bool = False,
    work: Work = HERE,
) -> tuple[Problem, tuple[float, float] | None]:
    """Fused problem, and the lag of the velocity channel when it is there and not yet in the model.

    any_lag: whatever lag deflection and accelerometers show is undone, however small or unsure.
    """
    known, records = known_lag(model), in_scale(records, model)
    if known is not None:
        return on_whole(
            prepare(records, sealed=sealed, velocity_lag=known, work=work), records
        ), None
    problem = prepare(records, sealed=sealed, work=work)
    found = problem.velocity_lag
    if sure(found, problem.motion.dt) or (any_lag and problem.kinematic_lag):
        undone = prepare(records, sealed=sealed, velocity_lag=found[0], work=work)
        return on_whole(undone, records), found
    return on_whole(problem, records), None


def sure(lag: tuple[float, float], dt: float) -> bool:
    """Whether a lag with its standard deviation [s] is there for certain, and counts at this sample time [s]."""
    return abs(lag[0]) > max(SMALLEST_LAG * dt, SURE_LAG * lag[1])


def as_given(model: Model, problem: Problem) -> Array:
    """Residual (n,) of a model without any refit [N]."""
    return np.asarray(problem.force - problem.predict(on_fused(model)))


def investigate(
    records: list[Record],
    model: Model,
    *,
    seed: int,
    sealed: int = 0,
    rule: Rule = RULE,
    work: Work = HERE,
    level: str = "damper",
    noted: Notes | None = None,
) -> Study:
    """Diagnose a model on records; a lagging velocity channel is undone first and named.

    What was found on stretches of long data is checked on all of them. Where the models do worse there, the worst
    stretches join the others and the search is repeated, once. noted: fits made before, to which new ones are added.
    """

    def once(records: list[Record], sealed: int) -> Study:
        study = _investigated(records, model, seed, sealed, rule, work, level, noted)
        return replace(study, records=tuple(records), checked=_checked(study))

    study = once(records, sealed)
    more = study.checked.missed if study.checked else []
    if more and not study.diagnosis.interrupted:
        study = once(*with_more(records, more))
    return _told(study, again=bool(more))


def _told(study: Study, *, again: bool) -> Study:
    """The study of long data with what was found on all of them in words."""
    if study.checked is None:
        return study
    long = long_json(study.checked, again=again)
    notes = (long_note(long), *study.problem.notes)
    return replace(study, long=long, problem=replace(study.problem, notes=notes))


def _checked(study: Study) -> Checked | None:
    """The model before and after the search, on all of long data."""
    found = study.diagnosis
    before, after = as_searched(found.base.fit), as_searched(found.best.fit)
    return checked(study.problem, found.best.fit.residual, before=before, after=after)


def _investigated(
    records: list[Record], model: Model, seed: int, sealed: int, rule: Rule, work: Work, level: str,
    noted: Notes | None,
) -> Study:  # fmt: skip
    """One diagnosis of records or stretches."""
    if level == "vehicle":
        problem, fitted = open_ride(records, model, sealed, work)
        problem = replace(problem, noted=noted)
        found = diagnose(fitted.model, problem, seed=seed, rule=rule)
        return _ridden(found, problem, model)
    problem, lag = open_problem(records, model, sealed, work=work)
    problem, bare = replace(problem, noted=noted), on_fused(model)
    lag_base = _as_measured(bare, problem) if lag else None
    found = diagnose(bare, problem, seed=seed, rule=rule)
    found = _restored(found, model)
    if lag:
        found = _with_lag(found, lag_base, lag, rule)
    return Study(found, problem, model, lag, lag_base, as_given(model, problem))


def add_effect(
    records: list[Record],
    model: Model,
    effect: str,
    *,
    seed: int,
    sealed: int = 0,
    work: Work = HERE,
    level: str = "damper",
) -> Study:
    """Add one named effect, refit everything, and judge it alone; on long data, check it on all of them."""
    study = _added(records, model, effect, seed, sealed, work, level)
    return _told(replace(study, records=tuple(records), checked=_checked(study)), again=False)


def _added(
    records: list[Record], model: Model, effect: str, seed: int, sealed: int, work: Work, level: str
) -> Study:  # fmt: skip
    """The study of one named effect on records or stretches."""
    if level == "vehicle":
        problem, fitted = open_ride(records, model, sealed, work)
        return _ridden(diagnose_one(fitted.model, problem, effect, seed), problem, model)
    asked = effect == "velocity_lag"
    problem, lag = open_problem(records, model, sealed, any_lag=asked, work=work)
    bare = on_fused(model)
    given = as_given(model, problem)
    if asked and not problem.measures_velocity:
        first = records[0]
        raise MissingChannel(
            first.source or first.name, "deflection_velocity", "to see that it lags", tuple(first.channels)
        )  # fmt: skip
    if asked and lag:
        base = _as_measured(bare, problem)
        inner = _restored(diagnose_one(bare, problem, None, seed), model)
        named = sure(lag, problem.motion.dt)
        found = _with_lag(inner, base, lag, RULE) if named else _beside_lag(inner, base, lag)
        return Study(found, problem, model, lag, base, given)
    if lag:
        problem = replace(problem, notes=(_undone(lag), *problem.notes))
    found = _restored(diagnose_one(bare, problem, effect, seed), model)
    return Study(found, problem, model, None, None, given)


def diagnose_one(model: Model, problem: Problem, effect: str | None, seed: int) -> Diagnosis:
    """Diagnosis that considers one effect (or none) only."""
    base = baseline(model, problem)
    rivals = [refit(base, model.catalogue[effect], problem, max_iter=20)] if effect else []
    null: Null = simulate_null(base, rivals, problem, seed)
    leader = min([base, *rivals], key=lambda c: c.mse)
    floor: Floor = noise_floor(problem, leader, null, seed)
    limit = threshold(null, floor.floor)
    able = [c for c in rivals if passes(base, c, limit)]
    step = Round(base, rivals, null, limit, able[0] if able else None, [])
    found = judge(base, able[0] if able else base, [step], floor, problem)
    return replace(found, best=rivals[0]) if rivals else found


def _ridden(found: Diagnosis, problem: Problem, model: Model) -> Study:
    """The study of a car, whose sensors are simulated: nothing is undone before."""
    return Study(found, problem, model, None, None, problem.force - problem.predict(model))


def _as_measured(model: Model, problem: Problem) -> Candidate:
    """The model refitted on the motion as the lagging channel shows it, where there is one: the error before."""
    m = problem.motion
    parts = [
        c.z[:, 1] if c.has[1] else m.v[i:j]
        for c, (i, j) in zip(problem.raw, pairwise(m.starts), strict=True)
    ]
    motion: Motion = replace(m, v=np.ascontiguousarray(np.concatenate(parts)))
    return baseline(model, replace(problem, motion=motion))


def _beside_lag(found: Diagnosis, before: Candidate, lag: tuple[float, float]) -> Diagnosis:
    """The diagnosis of a model that holds the lag of the velocity channel besides, whatever that is worth."""
    best = found.best
    model = best.fit.model.with_effect("velocity_lag", {"T_v": lag[0]})
    model = replace(model, deviations={**model.deviations, "velocity_lag": {"T_v": lag[1]}})
    to_explain, explained = shares(before.mse, best.mse, found.floor)
    return replace(
        found, base=before, best=replace(best, fit=replace(best.fit, model=model)),
        explainable=to_explain, explained=explained,
    )  # fmt: skip


def _with_lag(
    found: Diagnosis, before: Candidate | None, lag: tuple[float, float], rule: Rule
) -> Diagnosis:
    """The diagnosis with the lag of the velocity channel as its first named effect.

    The sensors show it whatever the force does. So it does not make up for what else is unknown: where it
    explains too little of that, or the data cannot decide about all else, the verdict says so.
    """
    assert before is not None
    whole = _beside_lag(found, before, lag)
    verdict = found.verdict
    if verdict == "adequate":
        verdict = "missing_effect"
    elif verdict == "insufficient_data":
        verdict = "ambiguous"
    elif verdict == "unknown_effect" and whole.explained >= rule.helps:
        verdict = "partial"
    return replace(
        whole, verdict=verdict, effects=("velocity_lag", *found.effects), reasons=(_lagging(lag), *found.reasons),
    )  # fmt: skip


def _lagging(lag: tuple[float, float]) -> str:
    """What the sensors show of a lag with its standard deviation [s]."""
    return f"the velocity channel lags deflection and accelerometers by {lag[0] * 1e3:.2f} +- {lag[1] * 1e3:.2f} ms"


def _undone(lag: tuple[float, float]) -> str:
    """What is said where another effect was asked for."""
    return f"{_lagging(lag)}: that is undone here, and the model does not hold it (lab add velocity_lag)"


def _restored(found: Diagnosis, model: Model) -> Diagnosis:
    """A diagnosis whose models hold again what `on_fused` left out."""
    base = _kept(found.base, model)
    return replace(
        found, base=base, best=base if found.best is found.base else _kept(found.best, model)
    )


def _kept(candidate: Candidate, model: Model) -> Candidate:
    """A candidate whose model still holds what `on_fused` left out."""
    kept = put_back(candidate.fit.model, model)
    return replace(candidate, fit=replace(candidate.fit, model=kept))


def final_model(study: Study, seed: int = 0) -> Model:
    """The best model with estimates of everything that was fitted: values without bias, and deviations."""
    best, problem = study.diagnosis.best.fit, study.problem
    if isinstance(problem.forward, RideForward):
        found = with_deviations(fit(best.model, problem, tol=1e-7), problem)
        return with_unfelt(found, study.model, problem)
    bare = as_searched(best)
    undone = set(KINEMATIC) - set(bare.effects)
    if isinstance(problem.forward, LongForward) and remembers(bare):
        found = with_deviations(fit(bare, problem, tol=1e-7), problem)
    else:
        found = estimated(replace(best, model=bare), problem, seed)
    found = with_unfelt(found, on_fused(study.model), problem)
    return put_back(found, best.model, only=undone)
