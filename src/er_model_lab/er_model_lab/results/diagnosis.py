"""The contract's JSON of `diagnose`, `add` and `improve`."""

from __future__ import annotations

from typing import Any

import numpy as np
from er_models.model import Model

from er_model_lab.diagnosis.coverage import Coverage
from er_model_lab.diagnosis.evidence import MUCH_MORE, VISIBLE
from er_model_lab.diagnosis.floor_estimates import floors
from er_model_lab.fitting.data_reach import Beyond, gap_note, held_out_beyond
from er_model_lab.level.study import Study
from er_model_lab.preflight.wild import outliers
from er_model_lab.residual.errors import size_notes
from er_model_lab.residual.unexplained import describe
from er_model_lab.results.candidate import candidates
from er_model_lab.results.steps import errors_of, steps
from er_model_lab.results.values import estimates

MOST_INPUTS, LEAST_WEIGHT = 5, 0.01
"""Inputs that the unexplained part is said to depend on, at most, and the share of it that each must carry [1]."""


def diagnosis_json(study: Study, model_after: Model) -> dict[str, Any]:
    """The contract's JSON of `diagnose`, `add` and `improve`."""
    found, problem = study.diagnosis, study.problem
    size, noise, unexplained = _sizes(study), _noise(study), _unexplained(study)
    left, fall = errors_of(study), steps(study)
    further = (
        held_out_beyond(problem, found.best.fit.residual) if problem.forward.outputs == 1 else None
    )
    unlike = _beyond(further) or unseen(left["rmse_after"])
    unlike += gap_note(model_after, problem) if problem.forward.outputs == 1 else ()
    return {
        "verdict": found.verdict,
        "effects": list(found.effects),
        "alternatives": [list(group) for group in found.alternatives],
        **left,
        "explainable": found.explainable,
        "explained": found.explained,
        "unexplained": unexplained,
        "candidates": candidates(study, model_after),
        "unknowable": [
            {"effect": e.name, "because": e.unknowable_because} for e in model_after.catalogue.unknowable()
        ],
        "steps": fall,
        "reasons": list(found.reasons),
        "noise": noise,
        "floors": {
            name: side.as_json()
            for name, side in floors(problem, found.best.fit.residual, found.floor.first).items()
        },
        "coverage": _coverage(found.coverage),
        "parameters": estimates(study.model, model_after, study.problem.forward.limits),
        "model": model_after.name,
        "notes": [*size, *unlike, *problem.notes],
        "outliers": outliers(study.data.originals, problem.beside),
        "held_out_beyond": further.as_json() if further else None,
        "complete": problem.complete,
    }  # fmt: skip


def _beyond(further: Beyond | None) -> tuple[str, ...]:
    """A note where the held-out data go beyond those learnt from, with a larger error there: it is no noise."""
    return () if further is None else (further.note("the held-out data", "those learnt from"),)


def _sizes(study: Study) -> tuple[str, ...]:
    """A note where the model as it was given is of another size: a force in kN fits a model as well as one in N."""
    return size_notes(study.problem, study.opened.given) if study.problem.fused else ()


def unseen(left: dict[str, float]) -> tuple[str, ...]:
    """A note where the model leaves much more of the held-out data than of those it was made with."""
    if not left["held_out"] > MUCH_MORE * left["train"]:
        return ()
    return (
        f"{left['held_out']:.3g} N are left of the held-out data, {left['train']:.3g} N of those learnt from: "
        "something may act there that the others do not show; more records would tell",
    )


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
        "deflection": found.deflection, "duty": list(found.duty), "tones": found.tones, "unlike": found.unlike,
    }  # fmt: skip


def _rest(study: Study) -> dict[str, Any]:
    """What is left depends on, where something is left that could be explained."""
    found = study.diagnosis
    unsaid = found.verdict in ("unknown_effect", "partial") or found.floor.explained > VISIBLE
    if not unsaid:
        return {}
    return {"rest": describe(study.problem, found.best.fit.residual).as_json()}
