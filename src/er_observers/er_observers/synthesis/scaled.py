"""A form, an output and a specification with everything divided by its typical size, and back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from er_models.linear import LinearForm
from er_models.model import Array

from er_observers.law import Law, luenberger
from er_observers.scaling import Scaling
from er_observers.synthesis.family import Family
from er_observers.synthesis.spec import Output, Spec

_DIGITS = 12


@dataclass(frozen=True, eq=False)
class Scaled:
    """The problem in scaled states, outputs, time and gate: x' = A x + B rho d + W w, y = C x + N w."""

    A: Array
    B: Array
    C: Array
    D1: Array
    Gamma: Array
    H: Array
    W: Array
    N: Array
    gate: float
    scaling: Scaling


def scale(form: LinearForm, output: Output, spec: Spec, scaling: Scaling) -> Scaled:
    """Divide everything by its typical size."""
    x, y, rate = scaling.state, scaling.output, scaling.rate
    gamma = form.Gamma * x
    gate = float(np.linalg.norm(gamma))
    return Scaled(
        A=form.A * x / x[:, None] / rate,
        B=(form.B / x / rate * gate)[:, None],
        C=form.C * x / y[:, None],
        D1=(form.D1 / x)[:, None],
        Gamma=(gamma / gate)[None, :],
        H=output.rows * x,
        W=spec.input_matrix(form) / x[:, None] / rate,
        N=spec.noise_matrix() / y[:, None],
        gate=gate,
        scaling=scaling,
    )


def law_of(s: Scaled, form: LinearForm, family: Family, rho: Array, Z: list[Array]) -> Law:
    """The law (SI) of gains Z at duties rho (K,), rounded to what will be written: what is proved is what is used."""
    x, y, rate = s.scaling.state, s.scaling.output, s.scaling.rate
    z = units(s, family)
    J = rounded(np.array([(family.B11 - g @ family.B12) * z[:, None] / y * rate for g in Z]))
    if z is x:
        return luenberger(form, rho, J, rounded(family.S * x[:, None] / y))
    M = np.array([(family.A11 - g @ family.A12) * z[:, None] / z * rate for g in Z])
    T, R, S = family.T * z[:, None] / x, family.R * x[:, None] / z, family.S * x[:, None] / y
    return Law(rho, rounded(M), J, *(rounded(v) for v in (T, R, S)))


def units(s: Scaled, family: Family) -> Array:
    """Size (N,) of one scaled unit of each observer state: the model's own where T is one."""
    own = family.T.shape[0] == len(s.scaling.state) and np.array_equal(
        family.T, np.eye(len(family.T))
    )
    return s.scaling.state if own else np.ones(family.T.shape[0])


def storage_of(s: Scaled, z: Array, P: Array) -> Array:
    """A Lyapunov matrix back in SI units; z (N,): size of one scaled unit of each state."""
    return rounded(0.5 * (P + P.T) / z / z[:, None] / s.scaling.rate)


def rounded(values: Array) -> Array:
    """Twelve significant digits."""
    return np.array([float(f"{v:.{_DIGITS}g}") for v in np.ravel(values)]).reshape(values.shape)
