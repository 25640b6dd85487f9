"""The level of the damper: its force, predicted from measured motion and duty.

Errors of the velocity channel are undone before anything is fitted, and put back into the model that is written.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from er_models.errors import MissingChannel
from er_models.model import Model
from er_records.dataset import Dataset
from er_records.duty_known import driven

from er_model_lab.diagnosis.candidates import Candidate, baseline
from er_model_lab.diagnosis.evidence import shares
from er_model_lab.diagnosis.floor_estimates import credible, floors
from er_model_lab.diagnosis.found import Diagnosis
from er_model_lab.diagnosis.investigation import one_effect, search_effects
from er_model_lab.diagnosis.noise_floor import noise_floor
from er_model_lab.diagnosis.null import simulate_null
from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.diagnosis.verdict import decide
from er_model_lab.fitting.data_reach import beyond
from er_model_lab.fitting.deviations import with_deviations
from er_model_lab.fitting.envelope import with_unfelt
from er_model_lab.fitting.velocity_channel import (
    KINEMATIC,
    as_searched,
    in_scale,
    known_lag,
    on_fused,
    put_back,
    restored,
)
from er_model_lab.fitting.wild_beside import without_wild
from er_model_lab.level.level import Judged, Question
from er_model_lab.level.study import Lag, Opened, Study
from er_model_lab.preflight.size import centre_notes
from er_model_lab.problem.fit_store import Notes
from er_model_lab.problem.fusion_facts import fusion_json
from er_model_lab.problem.prepare import prepare
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.errors import size_notes
from er_model_lab.residual.excess import noise_at
from er_model_lab.span.span import Span, spanned
from er_model_lab.terms.seen import held
from er_model_lab.work import HERE, Work

SMALLEST_LAG = 0.08
"""Lag of the velocity channel that counts, in samples."""
SURE_LAG = 8.0
"""Standard deviations of a lag from which it is undone: they know of noise alone, and a wrong lag spoils all else."""


class DamperLevel:
    """The force of a damper along its measured motion."""

    name, cost = "damper", 0.2

    def usable(self, data: Dataset) -> Dataset:
        """Records whose duty is known, where others are driven."""
        return driven(data)

    def given(self, asked: Question) -> Opened:
        """The data, fused, and what the model leaves of them."""
        return opened(asked.data, asked.model, work=asked.work)

    def judged(self, asked: Question) -> Judged:
        """The same with the floor that the refitted model leaves, and what else is known of the data."""
        data, model, seed, found = asked.data, asked.model, asked.seed, self.given(asked)
        problem, given = found.problem, found.given
        base = baseline(found.searched, problem)
        null = simulate_null(base, [], problem, seed)
        floor = credible(noise_floor(problem, base, null, seed), problem, base.fit.residual)
        further = beyond(model, problem, given)
        sides = floors(problem, base.fit.residual, floor)
        content = {
            "floors": {name: side.as_json() for name, side in sides.items()},
            "fusion": fusion_json(data.originals, problem),
            "rmse_refitted": float(np.sqrt(base.mse)),
            "beyond": further.as_json() if further else None,
        }
        notes = (
            *size_notes(problem, given), *centre_notes(data.originals, model), *held(found.searched, problem)
        )  # fmt: skip
        return Judged(
            found, floor.floor, noise_at(problem, floor.floor, null.input_square), content, notes
        )

    def reach_notes(self, opened: Opened) -> tuple[str, ...]:
        """What is said of motion and duty beyond those that the model was fitted to."""
        found = beyond(opened.model, opened.problem, opened.given)
        return (
            (found.note("these data", f"what '{opened.model.name}' was fitted to"),)
            if found and found.matters
            else ()
        )

    def searched(self, asked: Question, noted: Notes | None) -> Study:
        """What the model lacks; a velocity channel that lags is undone first and named."""
        found, rule = self.given(asked), asked.rule
        last, known = _before(found, asked), None
        if last is None:
            noting = replace(found, problem=replace(found.problem, noted=noted))
            found, known = _looked_again(noting)
        else:  # samples are weighed as before, so that what was tried then counts
            same = {n: getattr(last.problem, n) for n in ("fold", "held_out", "wild", "beside")}
            found = replace(found, problem=replace(found.problem, noted=noted, **same))
            known = replace(last.diagnosis.best, effects=())
        before = _as_measured(found) if found.lag else None
        begun = None if last is None else last.diagnosis.further
        seen = search_effects(
            found.searched, found.problem, seed=asked.seed, rule=rule, known=known, begun=begun
        )
        seen = _restored(seen, asked.model)
        if found.lag and before:
            seen = _with_lag(seen, before, found.lag, rule)
        return Study(found, seen, before)

    def added(self, asked: Question, effect: str | None) -> Study:
        """One effect, or none, judged alone; a lag of the velocity channel is undone whatever it is asked for."""
        if effect == "velocity_lag":
            return _with_asked_lag(asked)
        found, known = _looked_again(self.given(asked))
        if found.lag:
            said = f"{_lagging(found.lag)}: that is undone here, and the model does not hold it (add velocity_lag)"
            found = _noting(found, said)
        seen = one_effect(found.searched, found.problem, effect, asked.seed, known)
        return Study(replace(found, lag=None), _restored(seen, asked.model))

    def finished(self, study: Study, seed: int) -> Model:
        """Estimates free of the bias of noisy motion, with what was undone before put back."""
        best, problem = study.diagnosis.best.fit, study.problem
        bare = as_searched(best)
        undone = set(KINEMATIC) - set(bare.effects)
        if study.diagnosis.interrupted:  # whoever stopped it does not wait for better ones
            found = with_deviations(replace(best, model=bare), problem)
        elif (
            study.learnt
        ):  # parameters and term make up for each other: neither is moved by itself
            found = bare
        else:
            given = on_fused(study.model)
            found = study.opened.span.estimate(replace(best, model=bare), problem, seed, given)
        found = with_unfelt(found, on_fused(study.model), problem)
        return put_back(found, best.model, only=undone)

    def particulars(self, study: Study) -> Mapping[str, Any]:
        """On what the fused motion rests."""
        return {"fusion": fusion_json(study.data.originals, study.problem)}


def opened(data: Dataset, model: Model, *, any_lag: bool = False, work: Work = HERE) -> Opened:
    """The data fused, with the lag of the velocity channel undone where it is known, or certain.

    any_lag: whatever lag deflection and accelerometers show is undone, however small or unsure.
    """
    scaled, bare = in_scale(data, model), on_fused(model)
    problem, span, lag = _fused(scaled, known_lag(model), work, any_lag=any_lag)
    given = np.asarray(problem.force - problem.predict(bare))
    problem = without_wild(problem, given)
    return Opened(data, model, bare, problem, span, given, lag)


def _fused(
    data: Dataset, known: float | None, work: Work, *, any_lag: bool
) -> tuple[Problem, Span, Lag | None]:
    """The problem, and the lag that was found and undone; known: the lag that the model holds [s]."""
    problem, found = prepare(data, velocity_lag=known, work=work), None
    if known is None:
        seen = problem.velocity_lag
        if sure(seen, problem.motion.dt) or (any_lag and problem.kinematic_lag):
            problem, found = prepare(data, velocity_lag=seen[0], work=work), seen
    return *spanned(problem, data), found


def sure(lag: Lag, dt: float) -> bool:
    """Whether a lag with its standard deviation [s] is there for certain, and counts at this sample time [s]."""
    return abs(lag[0]) > max(SMALLEST_LAG * dt, SURE_LAG * lag[1])


def _with_asked_lag(asked: Question) -> Study:
    """The lag of the velocity channel added, from the motion sensors where they show one, else from the force."""
    data, model, seed = asked.data, asked.model, asked.seed
    found = opened(data, model, any_lag=True, work=asked.work)
    if not found.problem.measures_velocity:
        first = data.records[0]
        raise MissingChannel(
            first.source or first.name, "deflection_velocity", "to see that it lags", tuple(first.channels),
            first.cure,
        )  # fmt: skip
    if not found.lag:
        seen = one_effect(found.searched, found.problem, "velocity_lag", seed)
        return Study(found, _restored(seen, model))
    before = _as_measured(found)
    seen = _restored(one_effect(found.searched, found.problem, None, seed), model)
    if sure(found.lag, found.problem.motion.dt):
        return Study(found, _with_lag(seen, before, found.lag, RULE), before)
    return Study(found, _beside_lag(seen, before, found.lag), before)


def _before(found: Opened, asked: Question) -> Study | None:
    """The study before, where it fitted the model to the same samples along the same motion."""
    last = asked.last
    if last is None or found.lag or last.opened.lag or set(KINEMATIC) & set(asked.model.effects):
        return None
    one, other = last.problem, found.problem
    pairs = ((one.force, other.force), (one.motion.v, other.motion.v))
    return last if all(np.array_equal(a, b) for a, b in pairs) else None


def _looked_again(asked: Opened) -> tuple[Opened, Candidate | None]:
    """Without the samples that only show as wild beside the fitted model, and that model where there are none."""
    base = baseline(asked.searched, asked.problem)
    problem = without_wild(asked.problem, base.fit.residual)
    return (asked, base) if problem is asked.problem else (replace(asked, problem=problem), None)


def _noting(asked: Opened, note: str) -> Opened:
    """The question with a note more."""
    problem = replace(asked.problem, notes=(note, *asked.problem.notes))
    return replace(asked, problem=problem)


def _as_measured(asked: Opened) -> Candidate:
    """The model refitted on the motion as the lagging channel shows it, where there is one: the error before."""
    problem, m = asked.problem, asked.problem.motion
    parts = [
        c.z[:, 1] if c.has[1] else m.v[i:j]
        for c, (i, j) in zip(problem.raw, pairwise(m.starts), strict=True)
    ]
    motion = replace(m, v=np.ascontiguousarray(np.concatenate(parts)))
    return baseline(asked.searched, replace(problem, motion=motion))


def _with_lag(found: Diagnosis, before: Candidate, lag: Lag, rule: Rule) -> Diagnosis:
    """The diagnosis with the lag of the velocity channel as its first named effect."""
    whole = _beside_lag(found, before, lag)
    seen = replace(found.evidence, with_lag=whole.explained)
    return replace(
        whole, verdict=decide(seen, rule), evidence=seen, effects=("velocity_lag", *found.effects),
        reasons=(_lagging(lag), *found.reasons),
    )  # fmt: skip


def _beside_lag(found: Diagnosis, before: Candidate, lag: Lag) -> Diagnosis:
    """The diagnosis of a model that holds the lag of the velocity channel besides, whatever that is worth."""
    best = found.best
    model = best.fit.model.with_effect("velocity_lag", {"T_v": lag[0]})
    model = replace(model, deviations={**model.deviations, "velocity_lag": {"T_v": lag[1]}})
    to_explain, explained = shares(before.mse, best.mse, found.floor)
    return replace(
        found, base=before, best=replace(best, fit=replace(best.fit, model=model)),
        explainable=to_explain, explained=explained,
    )  # fmt: skip


def _lagging(lag: Lag) -> str:
    """What the sensors show of a lag with its standard deviation [s]."""
    return f"the velocity channel lags deflection and accelerometers by {lag[0] * 1e3:.2f} +- {lag[1] * 1e3:.2f} ms"


def _restored(found: Diagnosis, model: Model) -> Diagnosis:
    """A diagnosis whose models hold again what `on_fused` left out."""
    base = _kept(found.base, model)
    return replace(
        found, base=base, best=base if found.best is found.base else _kept(found.best, model)
    )


def _kept(candidate: Candidate, model: Model) -> Candidate:
    """A candidate whose model still holds what `on_fused` left out."""
    return replace(candidate, fit=restored(candidate.fit, model))
