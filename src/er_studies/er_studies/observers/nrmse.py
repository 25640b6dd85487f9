"""The error measure of the thesis and when an estimate has converged."""

from __future__ import annotations

import numpy as np
from er_models.model import Array

SETTLED = 0.02
"""Share of the true force's range below which an estimate counts as converged."""
_SPAN = 0.1


def nrmse(true: Array, estimate: Array) -> float:
    """Root mean square error (n,) against (n,) over the range of the true force, (3.79)-(3.80)."""
    return float(np.sqrt(np.mean(np.square(estimate - true)))) / float(np.ptp(true))


def settling_time(t: Array, true: Array, estimate: Array) -> float:
    """Time [s] from which the error's rms over 0.1 s stays below 2 % of the range; inf for never."""
    n = max(1, round(_SPAN / float(t[1] - t[0])))
    power = np.convolve(np.square(estimate - true), np.full(n, 1.0 / n))[: true.size]
    above = np.flatnonzero(power > (SETTLED * float(np.ptp(true))) ** 2)
    if above.size == 0:
        return 0.0
    return float(t[above[-1] + 1]) if above[-1] + 1 < t.size else float("inf")
