r"""NLPV polytopic observer: one Lyapunov function for every duty, gains at both ends of its range.

Theorem 4.3.1, with the sector q of the gate as a parameter. For the system
``x' = A x + B rho Phi(x) + D1 w, y = C x + n`` the observer

    x^' = A x^ + B rho Phi(x^) + L(rho) (y - C x^)

has a stable error for every rho(t) in [rho_1, rho_2], and an L2 gain below gamma from the weighted
(w, n) to H e, if there are P > 0, Y_i and l_i > 0 with the inequalities of `lmi` (A11 = A, A12 = C,
T = I, R = I - S C; S: `family`) at both ends; then L_i = P^{-1} Y_i, and L(rho) goes straight from L_1 to L_2. Each
inequality is affine in rho, so the ends are enough, even with a multiplier l_i of their own. With
q = (1, 0, -1), the Lipschitz bound, this is (4.12) as printed; with q = (0, 1, -2), the slope
restriction, it has solutions where (4.12) has none.

Source: thesis Theorem 4.3.1; Apkarian, Gahinet and Becker 1995.
"""

from __future__ import annotations

import numpy as np
from er_models.linear import LinearForm

from er_observers.scaling import Scaling
from er_observers.synthesis import lmi
from er_observers.synthesis.family import balanced_family
from er_observers.synthesis.proof import Claim
from er_observers.synthesis.spec import Output, Spec

THEOREM = "nlpv_polytopic (Theorem 4.3.1)"


def problem(form: LinearForm, output: Output, spec: Spec, scaling: Scaling) -> lmi.Problem:
    """The theorem's inequalities at both ends of the duty's range."""
    nodes = np.array(spec.rho)
    return lmi.Problem(THEOREM, form, output, spec, scaling, balanced_family, nodes)


def claim(form: LinearForm, output: Output, spec: Spec, scaling: Scaling) -> Claim:
    """Gains at both ends and P; raises `SynthesisFailed` naming what makes it impossible."""
    found = lmi.solve(problem(form, output, spec, scaling))
    return Claim(form, output, spec, scaling, found)
