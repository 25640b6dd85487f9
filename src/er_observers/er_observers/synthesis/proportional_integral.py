r"""Proportional-integral special case of the unified observer, (3.6).

.. math::  z' = N z + J y + H \rho\, \Phi(\hat x) + M v, \quad v' = y - C \hat x

With P = -C R, Q = I - C S and G = 0 the lower rows of Z are fixed, so that Y = X Z is no longer free
and the inequalities of `lmi` are not linear in X and the gain together. (The thesis prints M = -C R where P is
meant.) So N and J are those of the proportional observer, the integral is weak, M = -kappa (C R N^{-1})^+,
which makes ``v' = C R N^{-1} M v = -kappa v`` where z is fast, and X is sought for that gain. kappa is the
rate of the slowest error before yield, which no gain moves: nothing is made slower by the integral.

Source: thesis (3.6), Remark 3.2.1.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from er_models.linear import LinearForm

from er_observers.law import Law
from er_observers.scaling import Scaling
from er_observers.synthesis import lmi
from er_observers.synthesis.family import luenberger_family
from er_observers.synthesis.spec import Output, Solution, Spec
from er_observers.synthesis.unified import solve_proportional

THEOREM = "proportional-integral (3.6)"


def solve(form: LinearForm, output: Output, spec: Spec, scaling: Scaling) -> Solution:
    """The observer with its integral, and X; raises `SynthesisFailed` naming what makes it impossible."""
    inner = solve_proportional(form, output, spec, scaling)
    asked = lmi.Problem(
        THEOREM, form, output, spec, scaling, luenberger_family, inner.law.rho, degree=0
    )
    return lmi.analyse(asked, with_integral(form, inner.law, _slowest(form, inner.law)))


def _slowest(form: LinearForm, law: Law) -> float:
    """Decay of the slowest error with an open gate at the largest duty [1/s]."""
    loop = law.M[-1] + law.rho[-1] * np.outer(law.T @ form.B, form.Gamma @ law.R)
    return float(-np.max(np.linalg.eigvals(loop).real))


def with_integral(form: LinearForm, law: Law, kappa: float) -> Law:
    """The law with m more states, the integrals of y - C x^."""
    n, m = law.T.shape[1], form.C.shape[0]
    shown = form.C @ law.R
    M, J = [], []
    for N, gain in zip(law.M, law.J, strict=True):
        entry = -kappa * np.linalg.pinv(shown @ np.linalg.inv(N))
        M.append(np.block([[N, entry], [-shown, np.zeros((m, m))]]))
        J.append(np.vstack([gain, np.eye(m) - form.C @ law.S]))
    return replace(
        law,
        M=np.array(M),
        J=np.array(J),
        T=np.vstack([law.T, np.zeros((m, n))]),
        R=np.hstack([law.R, np.zeros((n, m))]),
    )
