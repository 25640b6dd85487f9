"""How much of a hidden effect is left after a healthy base has been refitted to it.

The base (k0, c0, fc, k1, c1, tau and a force offset) is fitted to the noiseless channels by
variable projection: k0, c0, fc and the offset are linear once k1, c1 and tau are given.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares
from scipy.signal import lfilter

from test.blind.jit import Array
from test.blind.plant import NOMINAL
from test.blind.slots import C1, K1, TAU

_PIECES = 8
_FORGET = 60
_SAMPLE = 0.005
_SCALE = np.array([100.0, 1.0, 1.0])


@dataclass(frozen=True)
class _Record:
    """Motion on a finer grid (n * PIECES,) and the channels at samples (n,)."""

    x_fine: Array
    v_fine: Array
    x: Array
    v: Array
    duty: Array
    force: Array


@dataclass(frozen=True)
class Refit:
    """What the refitted base leaves.

    Attributes:
        rms: of the residual [N].
        parameters: k0, c0, fc, k1, c1, tau, offset in SI units, (7,).
    """

    rms: float
    parameters: Array


def _prepare(clean: dict[str, Array]) -> _Record:
    t, x, v = clean["t"], clean["deflection"], clean["deflection_velocity"]
    centres = (np.arange(t.size * _PIECES) + 0.5) * _SAMPLE / _PIECES
    centres = np.minimum(centres, t[-1])
    return _Record(
        CubicSpline(t, x)(centres),
        CubicSpline(t, v)(centres),
        x,
        v,
        np.repeat(clean["duty"], _PIECES),
        clean["damper_force"],
    )


def _field(record: _Record, k1: float, c1: float, tau: float) -> Array:
    """Field force per unit fc at the samples, (n,), from zero."""
    gate = record.duty * np.tanh(k1 * record.x_fine + c1 * record.v_fine)
    keep = np.exp(-_SAMPLE / _PIECES / tau)
    response = lfilter([0.0, 1.0 - keep], [1.0, -keep], np.append(gate, 0.0))
    return np.asarray(response[:-1:_PIECES])


def _project(shape: Array, records: list[_Record], *, offset: bool) -> tuple[Array, Array]:
    """Residual of the best linear part [N] and that part (k0, c0, fc and the offset)."""
    k1, c1, tau = shape[0] * _SCALE[0], np.exp(shape[1]), np.exp(shape[2])
    rows, force = [], []
    for record in records:
        columns = [record.x, record.v, _field(record, k1, c1, tau)]
        if offset:
            columns.append(np.ones(record.x.size))
        rows.append(np.stack(columns, axis=1)[_FORGET:])
        force.append(record.force[_FORGET:])
    design, measured = np.concatenate(rows), np.concatenate(force)
    linear = np.linalg.lstsq(design, measured, rcond=None)[0]
    return design @ linear - measured, linear


def refit(clean: list[dict[str, Array]], *, offset: bool = True) -> Refit:
    """Fit the healthy base to noiseless records.

    Args:
        clean: contract columns of each record, as ``measure.noiseless`` makes them.
        offset: whether the base may use a constant force.
    """
    records = [_prepare(record) for record in clean]
    start = np.array([NOMINAL[K1] / _SCALE[0], np.log(NOMINAL[C1]), np.log(NOMINAL[TAU])])
    low = np.array([-30.0, np.log(20.0), np.log(1e-3)])
    high = np.array([30.0, np.log(2e4), np.log(0.5)])
    best = least_squares(
        lambda shape: _project(shape, records, offset=offset)[0],
        start,
        bounds=(low, high),
        xtol=1e-6,
        ftol=1e-6,
        max_nfev=40,
    )
    residual, linear = _project(best.x, records, offset=offset)
    linear = linear if offset else np.append(linear, 0.0)
    shape = [best.x[0] * _SCALE[0], np.exp(best.x[1]), np.exp(best.x[2])]
    parameters = np.array([*linear[:3], *shape, linear[3]])
    return Refit(float(np.sqrt(np.mean(residual**2))), parameters)


def excess(rms_left: float, noise: float) -> float:
    """Rise of the residual over the noise floor: 0.1 is 10 %."""
    return float(np.hypot(rms_left, noise) / noise - 1.0)


def left_for(rise: float, noise: float) -> float:
    """Residual [N] that makes the rise asked for; the inverse of ``excess``."""
    return float(noise * np.sqrt((1.0 + rise) ** 2 - 1.0))
