"""What a measured term looks like: the effects of the catalogue whose force comes nearest to it along the samples."""

from __future__ import annotations

from typing import Any

import numpy as np
from er_models.model import Array

from er_model_lab.diagnosis.candidates import additions, missing
from er_model_lab.diagnosis.starts import gaps, starts
from er_model_lab.problem.problem import Problem
from er_model_lab.terms.learn import Learnt

NEAREST = 3
"""Effects that are named."""
SAMPLES = 6_000
"""Samples on which they are compared."""


def looks_like(found: Learnt, problem: Problem) -> list[dict[str, Any]]:
    """The nearest effects, best first: name, correlation of its force with the term's, and the share it explains.

    What the model's own parameters can make is taken out of both, as in the search for effects.
    """
    rows = np.flatnonzero(problem.train)
    rows = rows[:: max(1, rows.size // SAMPLES)]
    j = np.hstack([found.before.fit.jacobian[rows], np.ones((rows.size, 1))])
    q = np.linalg.qr(j)[0]
    target = _beyond(q, found.force[rows][:, None])[:, 0]
    model, out = found.before.fit.model, list[dict[str, Any]]()
    for effect in missing(model, problem):
        if effect.stage == "vehicle":
            continue
        problem.work.check()
        points = gaps(effect, problem) or starts(effect, problem)
        shapes = _beyond(q, additions(found.before, effect, points, problem)[rows])
        size = np.linalg.norm(shapes, axis=0) * max(float(np.linalg.norm(target)), 1e-300)
        along = np.where(size > 0.0, shapes.T @ target / np.maximum(size, 1e-300), 0.0)
        best = float(along[np.argmax(np.abs(along))])
        out.append({"effect": effect.name, "correlation": best, "share": best**2})
    return sorted(out, key=lambda e: -e["share"])[:NEAREST]


def _beyond(q: Array, y: Array) -> Array:
    """Columns y (n, k) without what an orthonormal basis q (n, p) can make."""
    return np.asarray(y - q @ (q.T @ y))
