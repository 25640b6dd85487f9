r"""How badly conditioned every Lyapunov function must be that bears a sector: a necessary condition with a number.

Any P and gains Y that solve the inequalities of `lmi` solve, for the gate alone (w = 0, H = 0), along the errors that
no gain reaches, the columns of ``N = ker A_12``,

.. math::

    \begin{bmatrix}
    N^T (P A_{11} + A_{11}^T P + l q_{ss} G^T G) N & N^T (P T B \rho + l q_{sd} G^T) \\ * & l q_{dd}
    \end{bmatrix} \le 0, \quad I \le P \le \kappa I

after division by the smallest eigenvalue of P. The gains are gone, whatever the region of the poles, so the smallest
kappa is a lower bound of the condition of P in typical sizes. With q_ss >= 0 and q_sd = 0 it grows with the duty: a
solution for one is one for every smaller duty.

Near the duty where the static gain of the gate reaches the Lipschitz bound kappa grows without bound, and long before
that no solution can be told from none in doubles.

Source: projection lemma, Gahinet and Apkarian 1994.
"""

from __future__ import annotations

import cvxpy as cp
import numpy as np
from scipy.linalg import null_space

from er_observers.synthesis.family import Family
from er_observers.synthesis.scaled import Scaled
from er_observers.synthesis.solver import blocks, run
from er_observers.synthesis.spec import SLOPE, Sector, Spec

TOLERANCE = 1e-8
"""Relative accuracy that the solver asks of itself."""
RESOLVED = 1.0 / np.sqrt(TOLERANCE)
"""Condition from which the inequalities' own margins, small against their entries twice over, go below it."""
_SHARES = (1.0, 0.8, 0.6, 0.4)


def least_condition(s: Scaled, family: Family, sector: Sector, rho: float) -> float:
    """Smallest kappa of the module's docstring for a structure; infinite where the solver finds none."""
    n = family.A11.shape[0]
    (q_ss, q_sd), (_, q_dd) = sector.form
    P, kappa = cp.Variable((n, n), symmetric=True), cp.Variable()
    m, N, G = cp.Variable((1, 1)), null_space(family.A12), s.Gamma @ family.R
    S = P @ family.A11
    gate = N.T @ (P @ (family.T @ s.B) * rho + G.T @ m * q_sd)
    whole = blocks([
        [N.T @ (S + S.T + G.T @ m @ G * q_ss) @ N, gate],
        [gate.T, m * q_dd],
    ])  # fmt: skip
    asked = [P >> np.eye(n), kappa * np.eye(n) >> P, whole << 0]
    status = run(cp.Problem(cp.Minimize(kappa), asked))
    return float(np.asarray(kappa.value)) if status == "optimal" else float("inf")


def reason_of_condition(s: Scaled, family: Family, spec: Spec) -> str:
    """Sentence that names the condition and its number where it is beyond what doubles resolve, else ''."""
    most, grows = max(spec.rho), spec.sector.form[0, 1] == 0.0
    for rho in most * np.array(_SHARES if grows else _SHARES[:1]):
        found = least_condition(s, family, spec.sector, float(rho))
        if np.isfinite(found):
            break
    if not RESOLVED < found < np.inf:
        return ""
    other = least_condition(s, family, SLOPE, most)
    already = "" if rho == most else f"already at rho = {rho:g} and the more at {most:g} "
    return (
        f"{already or f'at rho = {most:g} '}every Lyapunov function for the {spec.sector.name} bound has a condition "
        f"number of {found:.3g} or more in typical sizes, whatever the gain; beyond {RESOLVED:.0e} the solver cannot "
        f"tell a solution from none (the {SLOPE.name} restriction asks for {other:.3g})"
    )
