"""The one right-hand side of the quarter car with its damper, as a plain function of state and input.

Linearisation, reference solutions and invariants use it; it calls the same compiled equations as the
integrator.
"""

from __future__ import annotations

import numpy as np

from er_models.kernel.load import kernel
from er_models.model import Array, Model


def vehicle_rate(
    model: Model, q: Array, w: Array, u: float, road_rate: float, t: float = 0.0
) -> tuple[Array, Array, Array]:
    """Rates of the mechanical state (4,) and damper states (n_states,), and outputs a_s, a_us, F_d.

    q = [z_def, v_s, z_us - z_r, v_us] as in (2.11); no dead time.
    """
    c, k = model.compiled(), kernel(model.catalogue)
    rate, drive = np.zeros(w.shape[0]), np.zeros(w.shape[0])
    a_s, a_us, f_d, _ = k.accelerations(c.on, c.p, w, q, u, t, road_rate, rate, drive)
    dw = np.zeros(w.shape[0])
    dw[c.slots] = drive[c.slots] - rate[c.slots] * w[c.slots]
    dq = np.array([q[1] - q[3], a_s, q[3] - road_rate, a_us])
    return dq, dw, np.array([a_s, a_us, f_d])


def damper_rate(
    model: Model, w: Array, x: float, v: float, a: float, u: float, t: float = 0.0
) -> tuple[Array, float]:
    """Rates of the damper states (n_states,) and the damper force [N] for an imposed motion."""
    c, k = model.compiled(), kernel(model.catalogue)
    rate, drive = np.zeros(w.shape[0]), np.zeros(w.shape[0])
    f_d, _, _ = k.evaluate(c.on, c.p, w, x, v, a, u, t, 0.0, rate, drive)
    dw = np.zeros(w.shape[0])
    dw[c.slots] = drive[c.slots] - rate[c.slots] * w[c.slots]
    return dw, float(f_d)
