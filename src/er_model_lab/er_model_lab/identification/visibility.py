"""What the data can say of each parameter: from the Fisher information of the fit and its covariance.

The part of a parameter's derivative that no other parameter can imitate decides. Where it is nothing, the
parameter cannot be known; where it is far below the noise, the value rests on averaging, and any small error
of model or motion outweighs its standard error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from er_models.model import Array

from er_model_lab.fitting.deviations import covariance
from er_model_lab.fitting.fit import Box, Fit
from er_model_lab.problem.forward import Free
from er_model_lab.problem.problem import Problem

UNKNOWN = 0.5
"""Standard deviation, over the parameter's size, from which the data do not say the parameter."""
WEAK = 0.1
"""Visibility below which a parameter is called weakly visible."""
TIED = 0.95
"""Correlation of two estimates from which they are called tied."""
IMITATED, PART = 0.9, 0.3
"""Correlation with the best mixture of others from which a parameter counts as taken up by them; least part in it."""
CHANGE = 0.1
"""Relative change of a parameter of which the visibility is stated."""


@dataclass(frozen=True)
class Visibility:
    """Per fitted parameter (p,).

    relative: standard deviation over the parameter's size; visible: change of the force [N rms] when the
    parameter is `CHANGE` off and all others have adjusted; noise: rms residual [N]; covariance (p, p) [SI] and
    correlation (p, p), NaN for parameters at a bound.
    """

    relative: Array
    visible: Array
    noise: float
    covariance: Array
    correlation: Array

    @property
    def unknown(self) -> np.ndarray:
        """Mask of the parameters that the data do not say."""
        return np.asarray(~(self.relative < UNKNOWN))

    @property
    def weak(self) -> np.ndarray:
        """Mask of the parameters that are only weakly visible."""
        return np.asarray(self.visible < WEAK * self.noise)


def visibility(fitted: Fit, problem: Problem) -> Visibility:
    """Visibility of the parameters of a fit on its training samples."""
    train = problem.train
    box = Box(fitted.model, fitted.free, problem.scales)
    size = np.maximum(np.abs(fitted.theta), box.size)
    derivative = fitted.jacobian[train] * size
    outside = _outside(derivative)
    noise = float(np.sqrt(fitted.mse(train)))
    spread = covariance(fitted, problem)
    sd = np.sqrt(np.maximum(np.diag(spread), 0.0))
    least = noise / np.maximum(outside * np.sqrt(float(train.sum())), 1e-300)
    relative = np.fmax(sd / (size * fitted.scale), least)
    share = np.abs(fitted.theta) / size
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = spread / np.outer(sd, sd)
    return Visibility(relative, CHANGE * outside * share, noise, spread, correlation)


def imitators(fitted: Fit, problem: Problem, which: int) -> Free:
    """The parameters that take up a change of another one, where they can do so nearly in full."""
    size = np.maximum(np.abs(fitted.theta), Box(fitted.model, fitted.free, problem.scales).size)
    derivative = fitted.jacobian[problem.train] * size
    column, others = derivative[:, which], np.delete(np.arange(size.size), which)
    share = np.linalg.lstsq(derivative[:, others], column, rcond=1e-10)[0]
    left = column - derivative[:, others] @ share
    if not np.mean(left**2) < (1.0 - IMITATED**2) * np.mean(column**2):
        return ()
    parts = np.abs(share) * np.sqrt(np.mean(derivative[:, others] ** 2, axis=0))
    return tuple(
        fitted.free[k] for k, part in zip(others, parts, strict=True) if part > PART * parts.max()
    )


def _outside(derivative: Array) -> Array:
    """Rms (p,) of the part of each column (n, p) that the other columns cannot imitate."""
    n, p = derivative.shape
    size = np.sqrt(np.mean(derivative**2, axis=0))
    unit = derivative / np.maximum(size, 1e-300)
    gram = unit.T @ unit / n
    found = np.zeros(p)
    for i in range(p):
        others = np.delete(np.arange(p), i)
        others = others[size[others] > 0.0]
        if size[i] == 0.0:
            continue
        imitated = np.linalg.lstsq(gram[np.ix_(others, others)], gram[others, i], rcond=1e-12)[0]
        found[i] = size[i] * np.sqrt(max(1.0 - gram[i, others] @ imitated, 0.0))
    return found
