"""Fills the contract's JSON and the views that reports and terminals draw."""

from __future__ import annotations

import math
from collections.abc import Mapping
from importlib import import_module
from itertools import pairwise
from typing import Any

import numpy as np
from er_models.model import Array, Model

from er_model_lab.compare import errors, regions_json, size_notes, worst
from er_model_lab.diagnose.candidates import Candidate, effect_size
from er_model_lab.diagnose.coverage import Coverage
from er_model_lab.diagnose.search import Round
from er_model_lab.diagnose.told import told
from er_model_lab.diagnose.verdict import VISIBLE, Diagnosis, shares
from er_model_lab.excess import noise_at, region_tables
from er_model_lab.fit import with_deviations
from er_model_lab.floors import floors
from er_model_lab.prepare import Problem
from er_model_lab.ride_result import ride_json
from er_model_lab.study import Study
from er_model_lab.unexplained import describe
from er_model_lab.view import CandidateView, RecordView, RegionTable, View

SHOWN = 12
"""Candidates that get an evidence card."""
POINTS = 600
"""Points of a signature picture."""
LEAST_KEPT = 0.02
"""Share of an effect's direction [1] that the model must leave it: below, no strength of it would show."""
LEAST_REACH = 0.02
"""Change of the force by an effect, over the noise of the force [1]: below, nothing of it can be seen, or missed."""
MOST_INPUTS, LEAST_WEIGHT = 5, 0.01
"""Inputs that the unexplained part is said to depend on, at most, and the share of it that each must carry [1]."""
MUCH_MORE = 1.5
"""Held-out error over that of the data learnt from, from which a note says so."""


def clean(value: Any) -> Any:
    """JSON without infinities and NaN: they become null."""
    if isinstance(value, Mapping):
        return {str(k): clean(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [clean(v) for v in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, np.integer):
        return int(value)
    return value


def parameters(model: Model, effect: str) -> dict[str, list[Any]]:
    """Values of an effect: {name: [value, standard deviation, unit]}."""
    out = {}
    for q in model.catalogue[effect].parameters:
        sd = model.deviations.get(effect, {}).get(q.name, float("inf"))
        out[q.name] = [float(model.effects[effect][q.name]), float(sd), q.unit]
    return out


def entry(
    candidate: Candidate, step: Round, found: Diagnosis, problem: Problem, after: Model
) -> dict[str, Any]:
    """One entry of `candidates` in the contract's JSON; an effect that was kept has the final model's values."""
    name = candidate.name
    kept = name in found.effects and name in after.effects
    model = after if kept else with_deviations(candidate.fit, problem)
    size = effect_size(step.base, candidate)
    status, rivals = _status(candidate, found)
    return {
        "effect": name,
        "rmse_held_out": errors(problem, candidate.fit.residual, problem.held_out).rmse,
        "rmse_before": errors(problem, step.base.fit.residual, problem.held_out).rmse,
        "rmse_cross_validated": float(np.sqrt(candidate.mse)),
        "evidence": size,
        "threshold": step.threshold,
        "p_value": step.null.p_value(size),
        "parameters": parameters(model, name),
        "status": status,
        "confounded_with": rivals,
        "kept_fraction": candidate.kept,
        "explains": shares(step.base.mse, candidate.mse, found.floor)[1],
    }


def _status(candidate: Candidate, found: Diagnosis) -> tuple[str, list[str]]:
    """Status of a candidate, and what it cannot be told from."""
    name = candidate.name
    for group in found.alternatives:
        if name in group:
            return "confounded", [other for other in group if other != name]
    if name in found.effects:
        return "present", []
    if _absorbed(candidate) or _out_of_reach(candidate):
        return "not_excited", []
    return "absent", []


def _absorbed(candidate: Candidate) -> bool:
    """Whether the other parameters of the model can make what the effect makes."""
    return candidate.kept < LEAST_KEPT


def _out_of_reach(candidate: Candidate) -> bool:
    """Whether the effect changes next to nothing on these data."""
    return candidate.reach < LEAST_REACH


def reason(candidate: Candidate, step: Round, found: Diagnosis) -> str:
    """Why a candidate was taken or not, in one sentence."""
    size = effect_size(step.base, candidate)
    if candidate.name in found.effects:
        return f"taken: lowers the error on unseen data by {size:.3g} N, chance reaches {step.threshold:.3g} N"
    if _absorbed(candidate):
        return "these data cannot show it: the model absorbs it completely"
    if _out_of_reach(candidate):
        return "not excited: in these data it would change the force by less than the noise"
    if size <= step.threshold:
        return f"not needed: {max(size, 0.0):.3g} N, chance alone reaches {step.threshold:.3g} N"
    taken = step.taken.name if step.taken else "none"
    return f"helps by {size:.3g} N, but {taken} explains the error better"


def unseen(study: Study) -> tuple[str, ...]:
    """A note where the model leaves much more of the held-out data than of those it was made with."""
    after, problem = study.diagnosis.best.fit.residual, study.problem
    train, held = (errors(problem, after, rows).rmse for rows in (problem.train, problem.held_out))
    if not held > MUCH_MORE * train:
        return ()
    return (
        f"{held:.3g} N are left of the held-out data, {train:.3g} N of those learnt from: "
        "something may act there that the others do not show; more records would tell",
    )


def notes(study: Study) -> tuple[str, ...]:
    """What to know of the data and of the model as it was given: a force in kN fits a model as well as one in N."""
    problem = study.problem
    size = size_notes(problem, study.given) if problem.fused else ()
    return (*size, *unseen(study), *problem.notes)


def diagnosis_json(study: Study, model_after: Model) -> dict[str, Any]:
    """The contract's JSON of `diagnose`, `add` and `improve`."""
    found, problem = study.diagnosis, study.problem
    return {
        "verdict": found.verdict,
        "effects": list(found.effects),
        "alternatives": [list(group) for group in found.alternatives],
        **_errors(study),
        "explainable": found.explainable,
        "explained": found.explained,
        "candidates": _candidates(study, model_after),
        "unknowable": [
            {"effect": e.name, "because": e.unknowable_because} for e in model_after.catalogue.unknowable()
        ],
        "steps": steps(study),
        "reasons": list(found.reasons),
        "unexplained": _unexplained(study),
        "noise": _noise(study),
        "floors": {
            name: side.as_json()
            for name, side in floors(problem, found.best.fit.residual, found.floor.first).items()
        },
        "coverage": _coverage(found.coverage),
        "model": model_after.name,
        "notes": list(notes(study)),
        "complete": problem.complete,
        **ride_json(study),
    }  # fmt: skip


def _errors(study: Study) -> dict[str, Any]:
    """Errors of the model as given, refitted and after, on both kinds of data, and the floors under them [N]."""
    found, problem = study.diagnosis, study.problem
    floor, after = found.floor.first, found.best.fit.residual
    train, held = (
        errors(problem, found.base.fit.residual, rows)
        for rows in (problem.train, problem.held_out)
    )
    return {
        "noise_floor": floor.held_out,
        "noise_floor_train": floor.floor,
        "rmse": {"train": train.rmse, "held_out": held.rmse},
        "nrmse": {"train": train.nrmse, "held_out": held.nrmse},
        "rmse_as_given": errors(problem, study.given, problem.held_out).rmse,
        "rmse_after": {
            "train": errors(problem, after, problem.train).rmse,
            "held_out": errors(problem, after, problem.held_out).rmse,
        },
    }


def _candidates(study: Study, model_after: Model) -> list[dict[str, Any]]:
    """Entries of all candidates: those that were taken, in their order, then the others by their error."""
    found = study.diagnosis
    entries = [entry(c, step, found, study.problem, model_after) for c, step in told(found)]
    if study.lag:
        entries = [e for e in entries if e["effect"] != "velocity_lag"]
        entries.insert(0, _lag_entry(study))
    order = {name: i for i, name in enumerate(found.effects)}
    entries.sort(key=lambda e: (order.get(e["effect"], len(order)), e["rmse_cross_validated"]))
    return entries


def _unexplained(study: Study) -> dict[str, Any]:
    """What is known of the part that no known effect explains; shares of the mean square [1], frequency [Hz]."""
    floor = study.diagnosis.floor
    heaviest = list(floor.importance.items())[:MOST_INPUTS]
    return {
        **_rest(study),
        "share": floor.explained,
        "bursts": floor.bursts,
        "depends_on": {name: weight for name, weight in heaviest if weight > LEAST_WEIGHT},
        "line": dict(zip(("frequency", "amplitude", "share"), floor.line, strict=True)),
    }


def _noise(study: Study) -> dict[str, Any]:
    """Noise of the force, and of the motion in it [N], of the motion sensors, and of the fused velocity [m/s]."""
    found, problem = study.diagnosis, study.problem
    noise, fused = problem.noise, problem.fused
    return {
        "force_white": found.floor.first.white,
        "input_error": found.floor.input_error,
        "motion": {"deflection": noise.x, "velocity": noise.v, "acceleration": noise.a},
        "fused_velocity_sd": float(np.mean([f.sd_v for f in fused])) if fused else None,
    }


def _coverage(found: Coverage) -> dict[str, Any]:
    """What the data hold: hints, what stands against a verdict, and the reach of motion and duty."""
    return {
        "hints": list(found.hints), "blocking": list(found.blocking), "velocity": found.velocity,
        "deflection": found.deflection, "duty": list(found.duty), "tones": found.tones,
    }  # fmt: skip


def _rest(study: Study) -> dict[str, Any]:
    """What is left depends on, where something is left that could be explained."""
    found = study.diagnosis
    unsaid = found.verdict in ("unknown_effect", "partial") or found.floor.explained > VISIBLE
    if not unsaid:
        return {}
    return {"rest": describe(study.problem, found.best.fit.residual).as_json()}


def _lag_entry(study: Study) -> dict[str, Any]:
    """Entry of the velocity channel's lag, whose evidence is kinematic."""
    assert study.lag is not None
    lag, sd = study.lag
    found, problem = study.diagnosis, study.problem
    return {
        "effect": "velocity_lag",
        "rmse_held_out": errors(problem, found.rounds[0].base.fit.residual, problem.held_out).rmse,
        "rmse_cross_validated": float(np.sqrt(found.rounds[0].base.mse)),
        "evidence": abs(lag) / max(sd, 1e-12),
        "p_value": float(math.erfc(min(abs(lag) / max(sd, 1e-12), 30.0) / math.sqrt(2.0))),
        "parameters": {"T_v": [lag, sd, "s"]},
        "status": "present" if "velocity_lag" in found.effects else "absent",
        "confounded_with": [],
        "basis": "deflection and accelerometers against the velocity channel",
    }


def steps(study: Study) -> list[dict[str, Any]]:
    """The falling error on held-out data, one entry per effect taken, with the evidence for it."""
    problem, found = study.problem, study.diagnosis
    held = problem.held_out
    base = study.lag_base or found.rounds[0].base
    out: list[dict[str, Any]] = [
        {"added": None, "rmse_held_out": errors(problem, base.fit.residual, held).rmse}
    ]
    if study.lag:
        rmse = errors(problem, found.rounds[0].base.fit.residual, held).rmse
        out.append({"added": "velocity_lag", "rmse_held_out": rmse})
    for step in found.rounds:
        taken = step.taken
        if taken is not None and set(taken.effects) <= set(found.effects):
            rmse = errors(problem, taken.fit.residual, held).rmse
            out.append(
                {"added": taken.name, "rmse_held_out": rmse, **_evidence(step, taken, problem)}
            )
    named = {s["added"] for s in out}
    left = [e for e in found.effects if e not in named]
    if left:
        rmse = errors(problem, found.best.fit.residual, held).rmse
        out.append({"added": " + ".join(left), "rmse_held_out": rmse})
    tried = found.rounds[0].candidates
    if len(out) == 1 and len(tried) == 1:
        # one effect was asked for: it is in the model, whether it helps or not
        rmse = errors(problem, tried[0].fit.residual, held).rmse
        out.append({"added": tried[0].name, "rmse_held_out": rmse})
    return out


def _evidence(step: Round, taken: Candidate, problem: Problem) -> dict[str, float]:
    """Effect size and its threshold [N], and the shares of blocks left out and of records whose error fell."""
    base, used = step.base, problem.used
    starts = problem.motion.starts * problem.forward.outputs
    runs = [slice(int(i), int(j)) for i, j in pairwise(starts) if used[i:j].any()]
    falls = used * (base.fit.residual**2 - taken.fit.residual**2)
    return {
        "evidence": float(effect_size(base, taken)),
        "threshold": float(step.threshold),
        "blocks": float(np.mean(base.losses > taken.losses)),
        "records": float(np.mean([falls[run].sum() > 0.0 for run in runs])),
    }


def headline(rmse: float, floor: float) -> str:
    """One line in newtons: what is unexplained, what of it is noise, what is the model's."""
    model = math.sqrt(max(rmse**2 - floor**2, 0.0))
    return f"unexplained {rmse:.3g} N, noise {floor:.3g} N, model {model:.3g} N"


def equation_of(model: Model, effect: str) -> str:
    """The equation of an effect as text, from its module."""
    hooks = model.catalogue[effect].hooks
    module = import_module(next(iter(hooks.values())).__module__) if hooks else None
    return (module.__doc__ or "").split("\n")[0].rstrip(".") if module else ""


def record_views(study: Study) -> tuple[RecordView, ...]:
    """Measured force, and the model before and after, per record."""
    problem, found = study.problem, study.diagnosis
    before = problem.force - found.base.fit.residual
    after = problem.force - found.best.fit.residual if found.best is not found.base else None
    return views(problem, before, after)


def views(problem: Problem, before: Array, after: Array | None) -> tuple[RecordView, ...]:
    """Per-record slices of a problem and its predictions, of the first output."""
    n, problem = problem.forward.outputs, problem.parts[0]
    before, after = before[::n], None if after is None else after[::n]
    m, out = problem.motion, []
    for name, i, j in zip(problem.names, m.starts[:-1], m.starts[1:], strict=True):
        cut = slice(int(i), int(j))
        out.append(
            RecordView(
                name, np.arange(j - i) * m.dt, m.x[cut], m.v[cut], m.u[cut], problem.force[cut], before[cut],
                None if after is None else after[cut], problem.used[cut], problem.held_out[cut],
            )
        )  # fmt: skip
    return tuple(out)


def candidate_views(study: Study, result: Mapping[str, Any]) -> tuple[CandidateView, ...]:
    """Evidence cards of the leading candidates."""
    found, problem = study.diagnosis, study.problem
    seen = {c.name: (c, step) for c, step in told(found)}
    shown = [e for e in result["candidates"] if e["effect"] in seen][:SHOWN]
    return tuple(_card(*seen[e["effect"]], found, problem, e) for e in shown)


def _card(
    candidate: Candidate,
    step: Round,
    found: Diagnosis,
    problem: Problem,
    fields: Mapping[str, Any],
) -> CandidateView:
    """One evidence card: the change of force the effect makes beside what the model left."""
    effect = candidate.fit.model.catalogue[candidate.name]
    n, problem = problem.forward.outputs, problem.parts[0]
    rows = np.flatnonzero(problem.train)
    rows = rows[:: max(1, rows.size // POINTS)]
    axis = {"force-deflection": problem.motion.x, "force-duty": problem.motion.u, "time": problem.motion.t,
            "force-acceleration": problem.motion.a}.get(effect.signature.plane, problem.motion.v)  # fmt: skip
    left = step.base.fit.residual[::n]
    change = left - candidate.fit.residual[::n]
    return CandidateView(
        candidate.name, effect.title, effect.physics, equation_of(candidate.fit.model, candidate.name),
        effect.signature.mark, effect.signature.experiment, fields, reason(candidate, step, found),
        effect.signature.plane, axis[rows], change[rows], left[rows],
    )  # fmt: skip


def study_regions(study: Study, seed: int) -> tuple[RegionTable, ...]:
    """Where the model, refitted with nothing added, fails."""
    found, problem = study.diagnosis, study.problem
    noise = noise_at(problem, found.floor.first.floor, found.null.input_square)
    return region_tables(problem, found.base.fit.residual, seed, noise)


def study_view(
    command: str, study: Study, result: Mapping[str, Any], provenance: Mapping[str, Any]
) -> View:
    """Everything a report of `diagnose`, `add` or `improve` shows."""
    found = study.diagnosis
    line = headline(result["rmse"]["held_out"], result["noise_floor"])
    return View(
        command=command, model=study.model.name, headline=line, result=result, records=record_views(study),
        candidates=candidate_views(study, result),
        notes=(*notes(study), *found.coverage.hints), provenance=provenance,
    )  # fmt: skip


def compare_json(
    problem: Problem,
    given: Array,
    floor: float,
    explainable: float,
    tables: tuple[RegionTable, ...],
) -> dict[str, Any]:
    """The contract's JSON of `compare`."""
    whole = errors(problem, given, problem.used)
    m, rows = problem.motion, problem.forward.outputs
    by_record = {}
    for name, i, j in zip(problem.names, m.starts[:-1], m.starts[1:], strict=True):
        mask = np.zeros(problem.force.size, bool)
        mask[i * rows : j * rows] = True
        by_record[name] = errors(problem, given, mask & problem.used).rmse
    return {
        "rmse": whole.rmse, "nrmse": whole.nrmse, "noise_floor": floor, "explainable": explainable,
        "worst": worst(tables), "regions": regions_json(tables), "rmse_by_record": by_record,
        "notes": list(problem.notes), "complete": problem.complete,
    }  # fmt: skip
