"""Steady tones in what a model leaves: lines of a spectrum that stand far above their neighbourhood."""

from __future__ import annotations

import numpy as np
from er_models.model import Array

from er_model_lab.problem.problem import Problem

SETTLED = 60
"""First samples of a record that are left out."""
LEAST = 256
"""Fewest samples of a spectrum."""
ABOVE = 40.0
"""Power of a line over the median around it."""


def longest(problem: Problem) -> slice:
    """Rows of the longest record, its first samples left out."""
    starts = problem.motion.starts
    k = int(np.argmax(np.diff(starts)))
    return slice(int(starts[k]) + SETTLED, int(starts[k + 1]))


def spectrum(y: Array) -> Array:
    """Power (k,) of a signal (n,) behind a Hann window."""
    return np.asarray(np.abs(np.fft.rfft((y - y.mean()) * np.hanning(y.size))) ** 2)


def stands_out(line: Array, power: Array, peak: int) -> bool:
    """Whether line[peak] is far above the neighbourhood that it has in power."""
    around = np.concatenate(
        [power[max(peak - 40, 2) : max(peak - 4, 2)], power[peak + 5 : peak + 41]]
    )
    return bool(around.size >= 10 and line[peak] > ABOVE * np.median(around))


def share_of(line: Array, power: Array, peak: int) -> float:
    """Share of the power that a line holds."""
    return float(line[max(peak - 2, 0) : peak + 3].sum()) / max(float(power.sum()), 1e-300)
