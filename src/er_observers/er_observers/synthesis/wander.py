"""Random scheduling: pairs of runs of the compiled observer along random duties and inputs."""

from __future__ import annotations

import numpy as np
from er_models.constants import SAMPLE_TIME
from er_models.model import Array

from er_observers.observers.kernel import advance, substeps
from er_observers.observers.matrices import plan_of
from er_observers.synthesis.proof import Claim


def wandering(
    claim: Claim, P: Array, samples: int = 2000, period: float = SAMPLE_TIME, seed: int = 0
) -> float:
    """Largest growth over one sample of ``sqrt(e' P e)`` between two runs; below 1 they converge.

    A new pair starts whenever the difference has shrunk a thousandfold, so that rounding does not
    decide. period: sample time [s].
    """
    random = np.random.default_rng(seed)
    form, rhos, size = claim.form, claim.spec.rho, claim.sizes
    plan = plan_of(form, claim.solution.law, claim.scaling)
    root = np.linalg.cholesky(P).T
    worst = start = 0.0
    x, y = np.zeros((2, size.size)), np.zeros((2, form.C.shape[0]))
    straight = np.zeros(form.C.shape[0])
    for _ in range(samples):
        before = float(np.linalg.norm(root @ (x[1] - x[0])))
        if before <= 1e-3 * start:
            x = size * random.normal(size=x.shape) * 10.0 ** random.uniform(-1, 1)
            before = start = float(np.linalg.norm(root @ (x[1] - x[0])))
        y = np.vstack([y[1], claim.scaling.output * random.normal(size=y.shape[1])])
        rho = random.choice([*rhos, random.uniform(*rhos)])
        after = np.empty_like(x)
        for run, out in zip(x, after, strict=True):
            advance(*plan, run, y[0], y[1], straight, rho, period, substeps(period), out, 0.0)
        x = after
        worst = max(worst, float(np.linalg.norm(root @ (x[1] - x[0]))) / before)
    return worst
