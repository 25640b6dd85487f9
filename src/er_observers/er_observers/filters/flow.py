r"""One substep of the model without measurement, with its Jacobian: what every Kalman filter predicts with.

The linear part is exact, the gate enters with its mean along the substep (`observers.gate`); the
unknown input is white, so it is zero in the mean and adds to the covariance
``Q_h = \int_0^h e^{A s} Q e^{A' s} ds`` (Van Loan 1978).
"""

from __future__ import annotations

import numpy as np
from er_models.linear import LinearForm
from er_models.model import Array

from er_observers.observers.compiled import compiled
from er_observers.observers.gate import gate_of, slopes_of, solve_gate
from er_observers.observers.phi import phi_functions


def substep_matrices(form: LinearForm, h: float) -> tuple[Array, Array]:
    """Transition (n, n) over h [s] and effect (n,) of a fully open gate at duty 1."""
    phi = phi_functions(h * form.A)
    return phi[0], np.asarray(h * phi[1] @ form.B)


def noise_covariance(form: LinearForm, density: Array, h: float) -> Array:
    """Covariance (n, n) that white noise of these densities (n,) [state^2/s] adds within h [s]."""
    n = form.n
    block = np.zeros((2 * n, 2 * n))
    block[:n, :n], block[:n, n:], block[n:, n:] = -form.A, np.diag(density), form.A.T
    grown = phi_functions(h * block)[0]
    covariance = grown[n:, n:].T @ grown[:n, n:]
    return np.asarray(0.5 * (covariance + covariance.T))


@compiled
def flow(linear: Array, kick: Array, gamma: Array, duty: float, x: Array) -> tuple[float, float]:
    """Move x (n,) one substep on, in place; returns the gate's slopes (k_0, k_1) for `jacobian`."""
    n = x.shape[0]
    free = np.zeros(n)
    s_0 = target = gain = 0.0
    for i in range(n):
        for j in range(n):
            free[i] += linear[i, j] * x[j]
        s_0 += gamma[i] * x[i]
        target += gamma[i] * free[i]
        gain += gamma[i] * kick[i] * duty
    t_0, area = gate_of(s_0)
    s_1, t_1, _, mean = solve_gate(s_0, t_0, area, target, gain)
    for i in range(n):
        x[i] = free[i] + duty * kick[i] * mean
    return slopes_of(s_0, t_0, s_1, t_1, mean)


@compiled
def jacobian(
    linear: Array, kick: Array, gamma: Array, duty: float, slopes: tuple[float, float], out: Array
) -> None:
    """Derivative (n, n) of a substep by its start, into out: the gate's row by Sherman and Morrison."""
    n = kick.shape[0]
    gain = 0.0
    for i in range(n):
        gain += gamma[i] * kick[i] * duty
    share = 1.0 / (1.0 - slopes[1] * gain)
    for j in range(n):
        along = 0.0
        for i in range(n):
            along += gamma[i] * linear[i, j]
        both = share * (slopes[0] * gamma[j] + slopes[1] * along)
        for i in range(n):
            out[i, j] = linear[i, j] + duty * kick[i] * both
