"""Prediction of the damper force from measured motion and duty."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from er_models.kernel.load import kernel, plain
from er_models.model import Array, Model
from er_models.parallel import over_cores

SUBSTEP = 0.625e-3
"""Longest step of the integrator [s]; the error at 200 Hz is shown by test_integrator_damper."""


@dataclass(frozen=True)
class Motion:
    """Inputs of a damper, one or more records laid end to end.

    x, v, a: deflection [m], velocity [m/s], acceleration [m/s2]; u: duty held from each sample on;
    theta: temperature difference [K]; all (n,). starts (m+1,): first rows of the records and the end.
    """

    dt: float
    x: Array
    v: Array
    a: Array
    u: Array
    theta: Array
    starts: np.ndarray

    @property
    def n(self) -> int:
        """Number of samples."""
        return int(self.x.shape[0])

    @property
    def t(self) -> Array:
        """Time since the start of each sample's record [s]."""
        out = np.empty(self.n)
        for i, j in zip(self.starts[:-1], self.starts[1:], strict=True):
            out[i:j] = np.arange(j - i) * self.dt
        return out


def motion(
    dt: float, x: Array, v: Array, u: Array, a: Array | None = None, theta: Array | None = None
) -> Motion:
    """One record as a `Motion`; the acceleration is derived from the velocity when absent."""
    n = x.shape[0]
    return Motion(
        dt=dt,
        x=np.ascontiguousarray(x, float),
        v=np.ascontiguousarray(v, float),
        a=np.gradient(v, dt) if a is None else np.ascontiguousarray(a, float),
        u=np.ascontiguousarray(u, float),
        theta=np.zeros(n) if theta is None else np.ascontiguousarray(theta, float),
        starts=np.array([0, n]),
    )


def join(parts: list[Motion]) -> Motion:
    """Several motions of equal sampling as one."""
    rows = np.concatenate([[0], np.cumsum([m.n for m in parts])])

    def joined(name: str) -> Array:
        return np.concatenate([getattr(m, name) for m in parts])

    return Motion(
        parts[0].dt,
        joined("x"),
        joined("v"),
        joined("a"),
        joined("u"),
        joined("theta"),
        starts=rows,
    )


def substeps(dt: float) -> int:
    """Integrator steps per sample."""
    return max(1, int(np.ceil(dt / SUBSTEP - 1e-9)))


def predict(model: Model, inputs: Motion) -> Array:
    """Measured damper force [N], shape (n,)."""
    force = np.empty(inputs.n)
    _rows(model, model.compiled().p[None], inputs)(force[None], 0, 1)
    return force


def predict_many(model: Model, vectors: Array, inputs: Motion) -> Array:
    """Forces (m, n) of one model for m flat parameter vectors (m, n_parameters), over all cores."""
    forces = np.empty((vectors.shape[0], inputs.n))
    rows = _rows(model, vectors, inputs)
    over_cores(lambda i, j: rows(forces, i, j), forces.shape[0], forces.size * substeps(inputs.dt))
    return forces


def _rows(model: Model, vectors: Array, inputs: Motion) -> Callable[[Array, int, int], None]:
    """What predicts rows i to j of the vectors into those of an array (m, n); it holds no lock of Python."""
    c, run, n_sub = model.compiled(), kernel(model.catalogue).predict_rows, substeps(inputs.dt)
    x, v, a, u, theta = map(plain, (inputs.x, inputs.v, inputs.a, inputs.u, inputs.theta))
    vectors, starts = plain(vectors), inputs.starts

    def rows(forces: Array, i: int, j: int) -> None:
        run(
            c.on, c.slots, c.links, c.at_rest, vectors[i:j], inputs.dt, starts, x, v, a, u, theta, n_sub, forces[i:j],
        )  # fmt: skip

    return rows
