r"""What any estimator could know at best: Fisher information of a drive, motion and healthy damper known exactly.

Only the noise of the sprung accelerometer hides anything. Two faults that make the forces F and F' are then

.. math::  d = \sqrt{\textstyle\sum (F - F')^2} / (m_s \sigma_a)

deviations apart, and the best rule mistakes one for the other with the probability :math:`\Phi(-d/2)`. The other
fault may have any size, so F' is the one nearest to F: the distance is that of Schur's complement.

Source: Kay 1993 (Fisher information), 1998 (detection).
"""

from __future__ import annotations

import numpy as np
from er_models.model import Array

from er_observers.faults.regression import BY_TAU, C0, F_ER, K0, M_S, S, advance
from er_observers.faults.rules import Estimator
from er_observers.faults.trials import Drive
from er_observers.scenarios.drive import DT

COLUMNS = {"f1": (2,), "f2": (0, 1, 2), "f3": (1, 2)}
"""Terms that each fault scales: stiffness, viscosity, yield force."""


def terms(p: Estimator, drive: Drive) -> Array:
    """Stiffness, viscosity and yield force (n, 3) [N] of the healthy damper along the true motion."""
    x, v = drive.motion.T
    a = np.gradient(v, DT)
    fluid, rows = np.zeros(BY_TAU + 4), np.zeros((x.size, 3))
    fluid[S] = p.p[4] * x[0] + p.p[5] * v[0]
    for k in range(1, x.size):
        duty = drive.samples[k - 1].duty
        ends = (x[k - 1], x[k]), (v[k - 1], v[k]), (a[k - 1], a[k])
        advance(p.p, fluid, *ends, 0.0, duty, DT)
        rows[k] = p.p[K0] * x[k], p.p[C0] * v[k], fluid[F_ER]
    return rows


def apart(p: Estimator, rows: Array, left: dict[str, float]) -> float:
    """Deviations between a single fault and the likeliest other one (0 where it is not one), over rows (n, 3)."""
    if len(left) != 1:
        return 0.0
    factor, value = next(iter(left.items()))
    own = np.ones(3)
    own[list(COLUMNS[factor])] = value
    force = rows @ own
    others = [_rest(rows, force, columns) for name, columns in COLUMNS.items() if name != factor]
    return float(min(others) / (p.p[M_S] * p.noise[0]))


def _rest(rows: Array, force: Array, columns: tuple[int, ...]) -> float:
    """Norm of what the best factor of these columns leaves of a force (n,) [N]."""
    scaled = rows[:, list(columns)].sum(axis=1)
    missing = force - (rows.sum(axis=1) - scaled)
    best = np.clip(scaled @ missing / max(scaled @ scaled, 1e-300), 0.0, 1.0)
    return float(np.linalg.norm(missing - best * scaled))
