"""The one right-hand side of the quarter car with its damper, as a plain function of state and input.

Linearisation uses it, and so do the reference solutions that the integrator is tested against; it calls the same
compiled equations as the integrator.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from er_models.kernel.load import kernel
from er_models.kernel.rows import ROWS, G, R, W
from er_models.model import Array, Model


def vehicle_point(
    model: Model,
    q: Array,
    w: Array,
    u: float,
    road_rate: float,
    t: float = 0.0,
    beside: float = 0.0,
) -> tuple[Array, Array, Array]:
    """Rates of the mechanical state (4,) and of the damper states (n_states,), and outputs (6,).

    q = [z_def, v_s, z_us - z_r, v_us] as in (2.11), [m, m/s]; no dead time. The outputs are a_s, a_us [m/s2], F_d, the
    measured force [N] and both reported accelerations [m/s2]. beside: force between the masses beside the damper [N].
    """
    return vehicle_points(model)(q, w, u, road_rate, t, beside)


def vehicle_points(model: Model) -> Callable[..., tuple[Array, Array, Array]]:
    """`vehicle_point` of one model, for many points: the model is laid out once."""
    c, point = model.compiled(plant=True), kernel(model.catalogue).vehicle_point

    def at(
        q: Array, w: Array, u: float, road_rate: float, t: float = 0.0, beside: float = 0.0
    ) -> tuple[Array, Array, Array]:
        rate, drive, out = np.zeros(w.shape[0]), np.zeros(w.shape[0]), np.zeros((1, 6))
        point(
            c.on, c.slots, c.links, c.p, np.asarray(q, float), np.asarray(w, float), float(u), float(t),
            float(beside), float(road_rate), rate, drive, out,
        )  # fmt: skip
        dw = np.zeros(w.shape[0])
        dw[c.slots] = drive[c.slots] - rate[c.slots] * w[c.slots]
        dq = np.array([q[1] - q[3], out[0, 0], q[3] - road_rate, out[0, 1]])
        return dq, dw, out[0]

    return at


def damper_rate(
    model: Model, w: Array, x: float, v: float, a: float, u: float, t: float = 0.0
) -> tuple[Array, float]:
    """Rates of the damper states (n_states,) and the damper force [N] for an imposed motion.

    What any solver needs to check `predict`, or a damper alone in another simulation.
    """
    c = model.compiled()
    s = np.zeros((ROWS, w.shape[0]))
    s[W], s[0] = w, w
    f_d, _, _ = kernel(model.catalogue).damper_point(
        c.on, c.links, c.p, s, float(x), float(v), float(a), float(u), float(t), 0.0
    )
    dw = np.zeros(w.shape[0])
    dw[c.slots] = s[G, c.slots] - s[R, c.slots] * w[c.slots]
    return dw, float(f_d)
