r"""The force with a deflection sensor and that of the accelerometers alone, pooled while they agree, compiled.

Both follow the model of the damper while it holds, and err for reasons of their own: one by the noise of the
deflection, the other by what happens between two samples. So each counts by the variance of the other,

.. math::  \hat F = F_f + g\, \frac{V_f}{V_f + V_a} (F_a - F_f), \quad
           V_a = \kappa (\theta m_s \sigma_a)^2 + (c_0\, r\, \Delta t)^2\, \overline{b^2}

F_f, V_f of the fusion, F_a of the accelerometers; b how the relative acceleration bends between samples. Under a fault,
friction or a load that only one of them knows, the mean square of F_a - F_f is far above V_f + V_a, and g is 0.

Source: ours. Pooling by inverse variances: Bar-Shalom, Li and Kirubarajan 2001, 8.3.
"""

from __future__ import annotations

import math

from er_models.model import Array

from er_observers.observers import fusion as of
from er_observers.observers.compiled import compiled

ALONE = 1.2
"""Variance of the force of the accelerometers alone over that of m_s y_1, on roads that are smooth between samples."""
BETWEEN = 1.7e-3
"""Error of their velocity from sample to sample, in shares of dt times the bend; ISO roads of class E leave 1.3e-3."""
WINDOW = 0.5
"""Average of the squared difference [s]."""
ALIKE = (0.7, 1.2)
"""Its mean over the sum of both variances up to which both count, and from which the fusion alone does.

They share the noise of the accelerometers, so a healthy damper leaves 0.4 to 0.9; friction, a fault or a load that only
one of them knows 2 and more."""
APART = 10.0
"""The same before anything is known."""
FAR = 1000.0
"""Largest squared difference over its variance that counts."""


@compiled
def pooled(
    p: Array, w: Array, found: tuple[bool, float, float, float], alone: float, sprung: float,
    seen: float, dt: float,
) -> tuple[bool, float, float, float]:  # fmt: skip
    """What `fusion.fuse` has found, its force pooled with that of the accelerometers `alone` [N], NaN for none.

    p, w: numbers and memory of the fusion, its mean difference brought on in place; sprung [m/s2], seen [m]: what the
    sensors say; dt: since the sample before [s].
    """
    believed, force, x, v = found
    if not (believed and math.isfinite(alone)):
        w[of.DIFFER] = APART
        return found
    fused, own = _variance(p, w), _variance_alone(p, w, dt)
    if not fused > 0.0:  # the rounding of a filter that knows its force
        return found
    differ = alone - force
    square = min(differ * differ / (fused + own), FAR)
    w[of.DIFFER] += min(1.0, dt / WINDOW) * (square - w[of.DIFFER])
    agree = min(max((ALIKE[1] - w[of.DIFFER]) / (ALIKE[1] - ALIKE[0]), 0.0), 1.0)
    force += agree * fused / (fused + own) * differ
    return True, of.banded(p, w, force, sprung, seen), x, v


@compiled
def _variance(p: Array, w: Array) -> float:
    """Variance of the fused force [N2], by the filter's covariance."""
    h_0, h_1 = p[of.K_0], p[of.C_0]
    a = h_0 * w[of.P00] + 2.0 * (h_1 * w[of.P01] + w[of.P02] + w[of.P03])
    b = h_1 * w[of.P11] + 2.0 * (w[of.P12] + w[of.P13])
    return float(h_0 * a + h_1 * b + w[of.P22] + 2.0 * w[of.P23] + w[of.P33])


@compiled
def _variance_alone(p: Array, w: Array, dt: float) -> float:
    """Variance of the force of the accelerometers alone [N2]."""
    noise = w[of.THETA] * p[of.M_S] * p[of.NOISE_A]
    between = p[of.C_0] * BETWEEN * dt
    return float(ALONE * noise * noise + between * between * w[of.BEND])
