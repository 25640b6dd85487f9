"""L2 gain of the error by frequency sweep, the gate frozen at slopes of its sector.

A bound from below that shares nothing with the inequalities: a gamma under it would show an error
in either.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from er_models.linear import LinearForm

from er_observers.synthesis.spec import Output, Solution, Spec


class Peak(NamedTuple):
    """Largest gain from weighted (w, n) to the output; frequency [rad/s], duty, slope there."""

    gain: float
    omega: float
    rho: float
    slope: float


def peak_gain(form: LinearForm, output: Output, spec: Spec, solution: Solution) -> Peak:
    """Peak over frequency, duty (ends and between) and slope of the gate (0 to 1)."""
    omega = np.concatenate([[0.0], np.logspace(-3, 6, 361)])
    worst = Peak(0.0, 0.0, 0.0, 0.0)
    for rho in np.linspace(spec.rho[0], spec.rho[1], 9):
        gain = solution.gain(float(rho), spec)
        entry = spec.input_matrix(form) - gain @ spec.noise_matrix()
        for slope in (0.0, 0.01, 0.1, 0.3, 1.0):
            a = form.A - gain @ form.C + slope * rho * np.outer(form.B, form.Gamma)
            pencils = 1j * omega[:, None, None] * np.eye(form.n) - a
            entries = np.broadcast_to(entry, (omega.size, *entry.shape))
            answers = output.rows @ np.linalg.solve(pencils, entries)
            gains = np.linalg.svd(answers, compute_uv=False)[:, 0]
            at = int(np.argmax(gains))
            if gains[at] > worst.gain:
                worst = Peak(float(gains[at]), float(omega[at]), float(rho), float(slope))
    return worst
