"""A measured term in the result of `improve`: what it is, what it gained, and what it looks like."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from er_models.measured import LABEL, QUANTITIES

from er_model_lab.diagnosis.candidates import effect_size
from er_model_lab.level.study import Study
from er_model_lab.output.text.units import moves
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.errors import errors
from er_model_lab.residual.unexplained import describe
from er_model_lab.results.by_record import by_record
from er_model_lab.results.passes import explained_by, left_after
from er_model_lab.results.values import clean
from er_model_lab.terms.formula import formula
from er_model_lab.terms.learn import Learnt
from er_model_lab.terms.own_file import own_effect
from er_model_lab.terms.shapes import looks_like
from er_model_lab.terms.spline import design

DRAWN = 40
"""Places along each quantity at which a term is drawn."""
NEAR = 0.25
"""Share of a term from which an effect is said to come near it."""
Json = dict[str, Any]


def term_json(found: Learnt, problem: Problem) -> Json:
    """What a term is, what it gained [N], the effects it looks like, and a formula with a file to begin from."""
    term, written = found.term, formula(found, problem)
    was, now = found.before, found.candidate
    held = {
        name: errors(problem, c.fit.residual, problem.held_out).rmse
        for name, c in (("before", was), ("after", now))
    }
    said: Json | None = None
    if written is not None:
        said = {
            "text": written.text,
            "share": written.share,
            "share_of_term": 1.0 - now.mse / was.mse,
        }
    return {
        "name": term.name, "label": LABEL, "quantities": list(term.quantities), "times": term.times, "lag": term.lag,
        "range": {q: list(r) for q, r in zip(term.quantities, term.ranges, strict=True)},
        "shape": list(term.shape), "rmse_held_out": held,
        "rmse_cross_validated": {"before": float(np.sqrt(was.mse)), "after": float(np.sqrt(now.mse))},
        "outside": _outside(found, problem), "looks_like": looks_like(found, problem), "formula": said,
        "drawn": _drawn(found, problem),
        "effect_source": own_effect(written, term.name, problem.scales) if written else None, "effect_file": None,
    }  # fmt: skip


def _drawn(found: Learnt, problem: Problem) -> Json:
    """The term on a grid of its quantities, [N] or [N] per unit of `times`; not where no sample lies."""
    axes = found.choice.axes
    edges = [np.linspace(*each, DRAWN + 1) for each in found.term.ranges]
    middles = np.meshgrid(*(0.5 * (e[1:] + e[:-1]) for e in edges), indexing="ij")
    force = design(axes, [m.ravel() for m in middles]) @ np.array(found.term.coefficients)
    seen = np.stack([found.values[q][problem.train] for q in found.term.quantities], axis=1)
    count = np.histogramdd(seen, edges)[0]
    shown = np.where(count.ravel() > 0, force, np.nan).reshape(count.shape)
    at = {q: e.tolist() for q, e in zip(found.term.quantities, edges, strict=True)}
    return {"edges": at, "force": shown.tolist()}


def _outside(found: Learnt, problem: Problem) -> float:
    """Share of the held-out samples in which a quantity lies beyond what was learnt, so that the term is held."""
    out = np.zeros(problem.held_out.size, bool)
    for quantity, (low, high) in zip(found.term.quantities, found.term.ranges, strict=True):
        out |= (found.values[quantity] < low) | (found.values[quantity] > high)
    return float(np.mean(out[problem.held_out]))


def note(entry: Json) -> str:
    """What was learnt, in a sentence."""
    held, like = entry["rmse_held_out"], entry["looks_like"]
    over = " and ".join(name.replace("_", " ") for name in entry["quantities"])
    times = f", times {entry['times'].replace('_', ' ')}" if entry["times"] else ""
    near = "; no effect of the catalogue comes near"
    if like and like[0]["share"] > NEAR:
        near = f"; nearest effect {like[0]['effect']} ({like[0]['share']:.0%} of it)"
    text = f"; a formula: {entry['formula']['text']}" if entry["formula"] else ""
    shape = f", {', '.join(entry['shape'])}" if entry["shape"] else ""
    ends = "; ".join(
        f"{q.replace('_', ' ')} {low:.3g} to {high:.3g} {QUANTITIES[q.removesuffix('_lagged')][1]}"
        for q, (low, high) in entry["range"].items()
    )
    beyond = f" ({entry['outside']:.0%} of the held-out data)" if entry["outside"] > 0.005 else ""
    return (
        f"{entry['name']}: {LABEL}; with a smooth term over {over}{times}{shape} the error on held-out data "
        f"{moves(held['before'], held['after'])}{near}{text}; held constant beyond {ends}{beyond}"
    )


def with_term(whole: Json, found: Learnt, study: Study, first: Study, limit: float) -> Json:
    """The content of a result with a term learnt last; study: of the model with it; limit: its least size [N]."""
    problem, after = study.problem, found.candidate
    left = after.fit.residual
    train, held = (errors(problem, left, mask).rmse for mask in (problem.train, problem.held_out))
    step = {
        "added": found.term.name, "rmse_train": train, "rmse_held_out": held,
        "evidence": effect_size(found.before, after), "threshold": limit,
        "blocks": float(np.mean(found.before.losses > after.losses)),
    }  # fmt: skip
    out = dict(whole) | explained_by(first.diagnosis, study.diagnosis)
    out["steps"] = [*whole["steps"], step]
    out["effects"] = [*whole["effects"], found.term.name]
    out["rmse_after"] = {"train": train, "held_out": held}
    # what it leaves is known to be within reach
    out["noise_floor"] = min(whole["noise_floor"], held)
    out["noise_floor_train"] = min(whole["noise_floor_train"], train)
    rest = describe(problem, left).as_json()
    out["unexplained"] = whole["unexplained"] | {"rest": rest}
    more: Json = {"by_record": by_record(study.diagnosis, problem, study.data)}
    if study.checked is not None:
        more["long"] = study.checked.as_json(again=study.again)
    out |= left_after(whole, more)
    entry = term_json(found, problem)
    entries, notes = [*whole["measured_terms"], entry], [note(entry), *whole["notes"]]
    told: Json = clean(out | {"measured_terms": entries, "notes": notes})
    return told


def as_study(study: Study, found: Learnt) -> Study:
    """The study of a model with what was learnt, as of a pass that added it."""
    diagnosis = replace(
        study.diagnosis,
        base=study.diagnosis.best,
        best=found.candidate,
        effects=(found.term.name,),
    )
    return replace(study, diagnosis=diagnosis, learnt=True)
