r"""Unified H-infinity observer: the unknown input decoupled exactly, a dynamic gain for the rest.

Theorem 3.3.1 and Algorithm 1. The observer

.. math::  z' = N z + J y + H \rho\, \Phi(\hat x) + M v, \quad v' = P z + Q y + G v, \quad
           \hat x = R z + S y

has an error free of the unknown input if T D1 = 0, N T + J C = T A, H = T B, P T + Q C = 0 and
R T + S C = I (3.8)-(3.12). With E of rank n beside C, ``Sigma = [E; C]``, all solutions are

.. math::  T = E - K C, \quad K = E D_1 (C D_1)^+, \quad
           \begin{bmatrix} N & M \\ P & G \end{bmatrix} = A_{11} - Z A_{12}

affine in one free Z (3.26)-(3.50); the inequalities of `lmi` at the ends of the duty's range, with one
X and Y = X Z, find it. That is (3.52) with U = 1 and, as the duty is known, (3.76); the sector of the gate is a
parameter. E = [C_perp'; R] with C = Q R, (3.78), made here from scaled matrices.

(3.41)-(3.42) are to be read with (3.40): N = alpha_3 - Y_m3 beta_1. As the free part acts through
``I - Sigma Sigma^+ = U U'`` only, Z has the columns of U and no others, which is the same set with
fewer unknowns.

Source: thesis Theorem 3.3.1, Algorithm 1; Gao, Darouach, Voos and Alma 2016.
"""

from __future__ import annotations

import numpy as np
from er_models.forms.linearise import rounded
from er_models.forms.zeros import invariant_zeros
from er_models.linear import LinearForm
from er_models.model import Array
from scipy.linalg import null_space, qr

from er_observers.scaling import Scaling
from er_observers.synthesis import lmi
from er_observers.synthesis.family import Family
from er_observers.synthesis.necessary import decoupling_ranks
from er_observers.synthesis.proof import Claim
from er_observers.synthesis.spec import Output, Solution, Spec, SynthesisFailed

THEOREM = "unified (Theorem 3.3.1)"
PROPORTIONAL = "proportional (3.5)"


def problem(
    form: LinearForm,
    output: Output,
    spec: Spec,
    scaling: Scaling,
    theorem: str = THEOREM,
    family: lmi.Maker | None = None,
) -> lmi.Problem:
    """The theorem's inequalities; raises `SynthesisFailed` where the road cannot be decoupled."""
    check_ranks(theorem, form)
    check_zeros(theorem, form)
    made = family or unified_family
    return lmi.Problem(theorem, form, output, spec, scaling, made, np.array(spec.rho), degree=0)


def claim(form: LinearForm, output: Output, spec: Spec, scaling: Scaling) -> Claim:
    """Matrices of (3.4) and X; raises `SynthesisFailed` naming what makes it impossible."""
    found = lmi.solve(problem(form, output, spec, scaling))
    return Claim(form, output, spec, scaling, found)


def solve_proportional(form: LinearForm, output: Output, spec: Spec, scaling: Scaling) -> Solution:
    """The special case (3.5), without v, Remark 3.3.1; raises as `claim`."""
    return lmi.solve(problem(form, output, spec, scaling, PROPORTIONAL, proportional_family))


def check_ranks(theorem: str, form: LinearForm) -> None:
    """Step 1 of Algorithm 1: raise `SynthesisFailed` where rank(C D1) is not rank(D1), (3.33)."""
    seen, whole = decoupling_ranks(form)
    if seen != whole:
        reason = (
            f"the unknown input {form.unknown_input} cannot be decoupled: rank(C D1) = {seen}, "
            f"rank(D1) = {whole}, (3.33)"
        )
        raise SynthesisFailed(theorem, reason)


def check_zeros(theorem: str, form: LinearForm) -> None:
    """Raise `SynthesisFailed` where an invariant zero of (A, D1, C) does not decay.

    An error free of the unknown input keeps the zeros among its poles, whatever the gain.
    """
    slowest = 1e-6 * float(np.abs(np.linalg.eigvals(form.A)).max())
    zeros = [z for z in invariant_zeros(form.A, form.D1[:, None], form.C) if z.real > -slowest]
    if zeros:
        names = ", ".join(f"{np.where(np.abs(z) < slowest, 0.0, z):.3g}" for z in zeros)
        reason = (
            f"the unknown input {form.unknown_input} has the invariant zero s = {names} 1/s: where it is "
            "decoupled exactly that is a pole of the error, whatever the gain, so no error decays"
        )
        raise SynthesisFailed(theorem, reason)


def unified_family(A: Array, C: Array, D1: Array) -> Family:
    """The observer (3.4): states z and v (n each), Z = [Y_m3 U, M; Y_m1 U, G]."""
    inner = proportional_family(A, C, D1)
    n, m = A.shape[0], C.shape[0]
    nothing, one = np.zeros((n, n)), np.eye(n)
    return Family(
        A11=np.block([[inner.A11, nothing], [nothing, nothing]]),
        A12=np.block([[inner.A12, np.zeros((len(inner.A12), n))], [np.zeros((n, n)), -one]]),
        B11=np.vstack([inner.B11, np.zeros((n, m))]),
        B12=np.vstack([inner.B12, np.zeros((n, m))]),
        T=np.vstack([inner.T, nothing]),
        R=np.hstack([inner.R, nothing]),
        S=inner.S,
    )


def proportional_family(A: Array, C: Array, D1: Array) -> Family:
    """The special case (3.5), M = P = Q = 0: state z alone, Z = Y_m3 U."""
    n, m = A.shape[0], C.shape[0]
    E = np.vstack([null_space(C).T, qr(C, mode="r")[0][:m]])
    K = E @ D1 @ np.linalg.pinv(C @ D1)
    T = rounded(E - K @ C)
    Sigma = np.vstack([E, C])
    back = np.linalg.pinv(Sigma)
    free = null_space(Sigma.T).T  # rows of U'
    theta = T @ A @ back
    with_K = np.vstack([K, np.eye(m)])
    return Family(
        A11=theta[:, :n],
        A12=free[:, :n],
        B11=theta @ with_K,
        B12=free @ with_K,
        T=T,
        R=rounded(back[:, :n]),
        S=rounded(back @ with_K),
    )
