"""Damper force along an imposed motion: one step after another over a record.

The text below the marker is compiled together with the equations of a catalogue
(`kernel.compose`).
"""

from __future__ import annotations

import numpy as np
from numba import prange

from er_models.kernel.fast import batch, entry, inner, record
from er_models.kernel.inputs import delayed, hermite, split
from er_models.kernel.states import HOLD, ROWS, keep, settle, solve, visit


def input_delay(on, p):  # type: ignore[no-untyped-def]
    """Composed from the catalogue: delay of the duty [s]."""
    raise NotImplementedError("replaced by kernel.compose")


def output_delay(on, p):  # type: ignore[no-untyped-def]
    """Composed from the catalogue: delay of the measured force [s]."""
    raise NotImplementedError("replaced by kernel.compose")


# --- below this line: compiled with the composed equations ---
@inner
def predict(on, slots, links, at_rest, p, dt, x, v, a, u, theta, n_sub, s, force):
    """Measured force [N] over one record of imposed motion, arrays of length n.

    The duty is held from each sample on, later by the dead time: a step that it jumps in is cut in
    two.
    """
    n = x.shape[0]
    whole, cut = split(input_delay(on, p) / dt)
    u_now = u[0]
    force[0] = settle(on, slots, at_rest, p, s, x[0], v[0], a[0], u_now, theta[0])
    for k in range(n):
        u_next = u[max(k - whole, 0)]
        m = min(k + 1, n - 1)
        end = 0.0
        for i in range(n_sub if k + 1 < n else 1):
            start = i / n_sub
            goal = (i + 1) / n_sub
            jump = u_now != u_next and start <= cut < goal
            for piece in range(0 if jump else 2, 3):
                q = cut if piece < 2 else goal
                if (piece == 0 and q == start) or (k + 1 == n and q > 0.0):
                    continue
                if piece == 1:
                    u_now = u_next
                x_q = hermite(x[k], v[k], x[m], v[m], dt, q)
                v_q = hermite(v[k], a[k], v[m], a[m], dt, q)
                a_q = (1.0 - q) * a[k] + q * a[m]
                th_q = (1.0 - q) * theta[k] + q * theta[m]
                h = (q - end) * dt
                _, f_m, _ = solve(
                    on, links, p, s, h, HOLD, x_q, v_q, a_q, u_now, (k + q) * dt, th_q
                )
                keep(slots, s)
                end = q
                if q == 0.0:
                    force[k] = f_m
        if k + 1 < n:
            force[k + 1] = f_m


@record
def predict_one(on, slots, links, at_rest, p, dt, starts, x, v, a, u, theta, n_sub, force):
    """Measured force of several records laid end to end; `starts` holds their first rows and the end."""
    shift = output_delay(on, p) / dt
    s = np.empty((ROWS, at_rest.shape[0]))
    for r in range(starts.shape[0] - 1):
        i, j = starts[r], starts[r + 1]
        predict(
            on, slots, links, at_rest, p, dt,
            x[i:j], v[i:j], a[i:j], u[i:j], theta[i:j], n_sub, s, force[i:j],
        )  # fmt: skip
        if shift != 0.0 and j - i > 1:
            raw = force[i:j].copy()
            delayed(raw, shift, force[i:j])


@entry
def predict_records(on, slots, links, at_rest, p, dt, starts, x, v, a, u, theta, n_sub, force):
    """As `predict_one`; the entry point that is compiled to disk."""
    predict_one(on, slots, links, at_rest, p, dt, starts, x, v, a, u, theta, n_sub, force)


@batch
def predict_batch(on, slots, links, at_rest, ps, dt, starts, x, v, a, u, theta, n_sub, forces):
    """One prediction per row of `ps` (m, n_parameters) into `forces` (m, n), over all cores."""
    for i in prange(ps.shape[0]):
        predict_one(
            on, slots, links, at_rest, ps[i], dt, starts, x, v, a, u, theta, n_sub, forces[i]
        )


@entry
def damper_point(on, links, p, s, x, v, a, u, t, theta):
    """Forces and duty at one instant with the states s[W]; fills rates and drives."""
    return visit(on, links, p, s, 0.0, HOLD, x, v, a, u, t, theta)


@entry
def settle_point(on, slots, at_rest, p, s, x, v, a, u, theta):
    """States s[W] in equilibrium with a motion, except those that start at rest; measured force [N]."""
    return settle(on, slots, at_rest, p, s, x, v, a, u, theta)
