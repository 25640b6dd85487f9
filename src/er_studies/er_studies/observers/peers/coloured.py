r"""Kalman filters of five states: the four relative ones and a coloured road, beside the white road of `kalman`.

.. math::  \dot d = -d / T + w, \quad d = \frac{d}{dt}(z_{us} - z_r)

d is the unknown input of the relative form. The filters are those of `er_observers.filters`, compiled.

Source: road as filtered noise: Dodds and Robson 1973; filters: Jazwinski 1970, Julier and Uhlmann 2004.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from er_models.constants import SAMPLE_TIME
from er_models.linear import LinearForm, relative_form
from er_models.model import Array, Model
from er_observers.filters.flow import noise_covariance, substep_matrices
from er_observers.running.runtime import Sample
from er_observers.scaling import road_density

from er_studies.observers import kalman
from er_studies.observers.kalman import Filter, State, Statement

TUNED = {"share": (0.01, 100.0), "time": (0.0003, 0.3), "noise": (0.01, 0.2)}
"""What is tuned, with bounds: share of the road's density, T [s], noise of the accelerometers [m/s2]."""


def make(name: str, model: Model, share: float, time: float, noise: float) -> Filter:
    """The filter `name` (ekf, ukf) with a road of time constant T [s]."""
    kind, form = kalman.KINDS[name], relative_form(model)
    wide = widened(form, time)
    h = SAMPLE_TIME / kind.n_sub
    linear, kick = substep_matrices(wide, h)
    density = np.zeros(wide.n)
    density[-1] = share * road_density(model) / time**2
    spread = (*Statement().spread, float(np.sqrt(0.5 * density[-1] * time)))
    made = Filter(
        kind, wide, h, linear, kick, noise_covariance(wide, density, h),
        C=np.ascontiguousarray(wide.C),
        variance=np.full(wide.C.shape[0], noise**2),
        first=np.diag(np.square(spread)),
        force=tuple(wide.F.tolist()),
    )  # fmt: skip
    rest = Sample(0.0, 0.0, 0.0, 0.0)
    step(made, start(made, rest), rest._replace(t=SAMPLE_TIME))
    return made


def widened(form: LinearForm, time: float) -> LinearForm:
    """The form with its unknown input as last state, which fades within T [s]."""
    n, wide = form.n, np.zeros((form.n + 1, form.n + 1))
    wide[:n, :n], wide[:n, n], wide[n, n] = form.A, form.D1, -1.0 / time
    return replace(
        form, A=wide, B=np.append(form.B, 0.0), C=np.pad(form.C, ((0, 0), (0, 1))),
        D1=np.append(0.0 * form.D1, 1.0), Gamma=np.append(form.Gamma, 0.0),
        F=np.append(form.F, 0.0), states=(*form.states, "road"),
    )  # fmt: skip


def start(p: Filter, sample: Sample, x: Array | None = None) -> State:
    """As `kalman.start`, x (4,) in relative coordinates."""
    return kalman.start(p, sample, None if x is None else np.append(x, 0.0))


step = kalman.step
