"""The motion as other draws of its sensors' noise would have shown it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from er_models.predict import Motion, join

from er_model_lab.fuse import as_measured, fuse

if TYPE_CHECKING:
    from er_model_lab.prepare import Problem


def renoised(problem: Problem, rng: np.random.Generator) -> Motion:
    """The fused motion taken as true, measured with fresh noise of every sensor, and fused again."""
    m, parts = problem.motion, []
    for r, (channels, fused) in enumerate(zip(problem.raw, problem.fused, strict=True)):
        i, j = m.starts[r], m.starts[r + 1]
        noise = fused.noise
        sd = np.array([noise.x, noise.v, noise.a])
        clean = as_measured(fused, m.dt)
        noisy = replace(channels, z=clean + rng.standard_normal(clean.shape) * sd)
        again = fuse(noisy, noise)
        a = again.a if channels.has[2] or not channels.measured_a else m.a[i:j]
        u, theta, ends = m.u[i:j], m.theta[i:j], np.array([0, j - i])
        parts.append(replace(m, x=again.x, v=again.v, a=a, u=u, theta=theta, starts=ends))
    return join(parts)
