r"""The only place that knows a time step.

Every state of the damper relaxes, ``w' = drive - rate w`` with ``rate >= 0``. Both stages of the L-stable,
stiffly accurate SDIRK2 method (Alexander 1977, gamma = 1 - 1/sqrt 2) are then solved without a Newton
iteration, however stiff the state. In the quarter car the damper force reacts to the velocity within
microseconds (the tanh of a static model); there each stage solves one scalar equation, monotone in the
relative velocity, by a bracketed secant.

The text below the marker is compiled together with the equations of a catalogue (`kernel.compose`).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange


def evaluate(on, p, w, x, v, a, u, t, theta, rate, drive):  # type: ignore[no-untyped-def]
    """Composed from the catalogue: force, measured force and duty; fills rate and drive."""
    raise NotImplementedError("replaced by kernel.compose")


def chassis(on, p, x, v, z_t, v_t, v_s):  # type: ignore[no-untyped-def]
    """Composed from the catalogue: spring force, tyre force and masses."""
    raise NotImplementedError("replaced by kernel.compose")


def input_delay(on, p):  # type: ignore[no-untyped-def]
    """Composed from the catalogue: delay of the duty [s]."""
    raise NotImplementedError("replaced by kernel.compose")


def output_delay(on, p):  # type: ignore[no-untyped-def]
    """Composed from the catalogue: delay of the measured force [s]."""
    raise NotImplementedError("replaced by kernel.compose")


# --- below this line: compiled with the composed equations ---
GAMMA = 1.0 - 1.0 / math.sqrt(2.0)


@njit(error_model="numpy")
def held_mean(u, s0, s1):
    """Mean over [s0, s1] (in samples, at most one long) of a duty that is held from each sample on."""
    last = u.shape[0] - 1
    k0 = int(math.floor(s0))
    k1 = int(math.floor(s1))
    u0 = u[min(max(k0, 0), last)]
    if k0 == k1 or s1 <= s0:
        return u0
    return (u0 * (k1 - s0) + u[min(max(k1, 0), last)] * (s1 - k1)) / (s1 - s0)


@njit(error_model="numpy")
def hermite(y0, d0, y1, d1, h, s):
    """Cubic through values and slopes at both ends of an interval of length h, at s in [0, 1]."""
    s2 = s * s
    s3 = s2 * s
    return (
        (2.0 * s3 - 3.0 * s2 + 1.0) * y0
        + (s3 - 2.0 * s2 + s) * h * d0
        + (3.0 * s2 - 2.0 * s3) * y1
        + (s3 - s2) * h * d1
    )


@njit(error_model="numpy")
def stage(on, slots, passes, p, base, w, x, v, a, u, t, theta, gh, rate, drive):
    """Solve one implicit stage for all states; `passes` > 1 where states drive one another."""
    for _ in range(passes):
        evaluate(on, p, w, x, v, a, u, t, theta, rate, drive)
        for i_s in range(slots.shape[0]):
            s = slots[i_s]
            w[s] = (base[s] + gh * drive[s]) / (1.0 + gh * rate[s])


@njit(error_model="numpy")
def settle(on, slots, at_rest, p, w, x, v, a, u, t, theta, rate, drive):
    """Start every state in equilibrium with the first sample, except those that start at rest."""
    for _ in range(4):
        evaluate(on, p, w, x, v, a, u, t, theta, rate, drive)
        for i_s in range(slots.shape[0]):
            s = slots[i_s]
            if at_rest[s] or rate[s] <= 0.0:
                w[s] = 0.0
            else:
                w[s] = drive[s] / rate[s]


@njit(error_model="numpy")
def predict(on, slots, at_rest, passes, p, dt, t0, x, v, a, u, theta, n_sub, w, force, field):
    """Measured force [N] and yield-side duty over one record of imposed motion, arrays of length n."""
    n = x.shape[0]
    n_states = w.shape[0]
    rate = np.zeros(n_states)
    drive = np.zeros(n_states)
    base = np.zeros(n_states)
    k_w = np.zeros(n_states)
    h = dt / n_sub
    gh = GAMMA * h
    lag = input_delay(on, p) / dt
    u0 = held_mean(u, -lag, -lag)
    settle(on, slots, at_rest, p, w, x[0], v[0], a[0], u0, t0, theta[0], rate, drive)
    for k in range(n):
        u_k = held_mean(u, k - lag, k - lag)
        f_d, f_m, u_f = evaluate(on, p, w, x[k], v[k], a[k], u_k, t0 + k * dt, theta[k], rate, drive)
        force[k] = f_m
        field[k] = u_f
        if k == n - 1:
            break
        for i in range(n_sub):
            s0 = i / n_sub
            u_i = held_mean(u, k + s0 - lag, k + (i + 1) / n_sub - lag)
            for c in range(2):
                s = s0 + (GAMMA if c == 0 else 1.0) / n_sub
                x_c = hermite(x[k], v[k], x[k + 1], v[k + 1], dt, s)
                v_c = hermite(v[k], a[k], v[k + 1], a[k + 1], dt, s)
                a_c = (1.0 - s) * a[k] + s * a[k + 1]
                th_c = (1.0 - s) * theta[k] + s * theta[k + 1]
                if c == 0:
                    for i_j in range(slots.shape[0]):
                        j = slots[i_j]
                        base[j] = w[j]
                else:
                    for i_j in range(slots.shape[0]):
                        j = slots[i_j]
                        k_w[j] = (w[j] - base[j]) / gh
                        base[j] += (1.0 - GAMMA) * h * k_w[j]
                stage(on, slots, passes, p, base, w, x_c, v_c, a_c, u_i, t0 + (k + s) * dt, th_c, gh, rate, drive)


@njit(error_model="numpy")
def delayed(y, d, out):
    """Series y shifted later by d samples, cubic between samples; the ends are held."""
    n = y.shape[0]
    for k in range(n):
        s = min(max(k - d, 0.0), n - 1.0)
        i = min(int(s), n - 2)
        f = s - i
        y0, y1 = y[i], y[i + 1]
        m0 = 0.5 * (y1 - y[i - 1]) if i > 0 else y1 - y0
        m1 = 0.5 * (y[i + 2] - y0) if i + 2 < n else y1 - y0
        out[k] = hermite(y0, m0, y1, m1, 1.0, f)


@njit(error_model="numpy")
def predict_one(on, slots, at_rest, passes, p, dt, starts, x, v, a, u, theta, n_sub, force):
    """Measured force of several records laid end to end; `starts` holds their first rows and the end."""
    shift = output_delay(on, p) / dt
    field = np.empty(x.shape[0])
    for r in range(starts.shape[0] - 1):
        i, j = starts[r], starts[r + 1]
        w = np.zeros(at_rest.shape[0])
        predict(
            on, slots, at_rest, passes, p, dt, 0.0,
            x[i:j], v[i:j], a[i:j], u[i:j], theta[i:j], n_sub, w, force[i:j], field[i:j],
        )  # fmt: skip
        if shift != 0.0:
            raw = force[i:j].copy()
            delayed(raw, shift, force[i:j])


@njit(cache=True, error_model="numpy")
def predict_records(on, slots, at_rest, passes, p, dt, starts, x, v, a, u, theta, n_sub, force):
    """As `predict_one`; the entry point that is compiled to disk."""
    predict_one(on, slots, at_rest, passes, p, dt, starts, x, v, a, u, theta, n_sub, force)


@njit(cache=True, parallel=True, error_model="numpy")
def predict_batch(on, slots, at_rest, passes, ps, dt, starts, x, v, a, u, theta, n_sub, forces):
    """One prediction per row of `ps` (m, n_parameters) into `forces` (m, n), over all cores."""
    for i in prange(ps.shape[0]):
        predict_one(on, slots, at_rest, passes, ps[i], dt, starts, x, v, a, u, theta, n_sub, forces[i])


@njit(error_model="numpy")
def damper_at(on, slots, passes, p, base, w, x, v, a, u, t, gh, rate, drive):
    """Damper force with its states solved implicitly for this motion; w is overwritten."""
    stage(on, slots, passes, p, base, w, x, v, a, u, t, 0.0, gh, rate, drive)
    f_d, f_m, _ = evaluate(on, p, w, x, v, a, u, t, 0.0, rate, drive)
    return f_d, f_m


@njit(error_model="numpy")
def try_velocity(on, slots, passes, p, q0, base, w, q, v, u, t, gh, road_rate, rate, drive):
    """Mechanical state q of a stage for a trial relative velocity v, and the velocity that follows from it."""
    q[0] = q0[0] + gh * v
    q[2] = q0[2] + gh * (q[3] - road_rate)
    a = (v - (q0[1] - q0[3])) / gh
    f_d, _ = damper_at(on, slots, passes, p, base, w, q[0], v, a, u, t, gh, rate, drive)
    f_s, f_t, m_s, m_us = chassis(on, p, q[0], v, q[2], q[3] - road_rate, q[1])
    q[1] = q0[1] - gh * (f_s + f_d) / m_s
    q[3] = q0[3] + gh * (f_s + f_d - f_t) / m_us
    return q[1] - q[3]


@njit(error_model="numpy")
def mechanical_stage(on, slots, passes, p, q0, base, w, q, u, t, gh, road_rate, tolerance, rate, drive):
    """Solve one implicit stage of the quarter car: r(v) = v - follow(v) grows with v, so bracket and secant."""
    v0 = q[1] - q[3]
    r0 = v0 - try_velocity(on, slots, passes, p, q0, base, w, q, v0, u, t, gh, road_rate, rate, drive)
    v1 = v0 - r0
    low, high = -1e300, 1e300
    for _ in range(40):
        r1 = v1 - try_velocity(on, slots, passes, p, q0, base, w, q, v1, u, t, gh, road_rate, rate, drive)
        if abs(r1) < tolerance:
            break
        if r1 > 0.0:
            high = min(high, v1)
        else:
            low = max(low, v1)
        slope = (r1 - r0) / (v1 - v0) if v1 != v0 else 1.0
        v0, r0 = v1, r1
        v1 = v1 - r1 / max(slope, 0.5)
        if not (low < v1 < high):
            v1 = 0.5 * (low + high) if low > -1e299 and high < 1e299 else v0 - 0.5 * r0
    return q[1] - q[3]


@njit(error_model="numpy")
def accelerations(on, p, w, q, u, t, road_rate, rate, drive):
    """Sprung and unsprung acceleration [m/s2], true and measured force [N] of a state.

    The damper force may depend on the acceleration (fluid inertia) in a straight line: two trials solve it.
    """
    v = q[1] - q[3]
    f_s, f_t, m_s, m_us = chassis(on, p, q[0], v, q[2], q[3] - road_rate, q[1])
    a0 = 0.0
    f0, m0, _ = evaluate(on, p, w, q[0], v, a0, u, t, 0.0, rate, drive)
    a1 = -(f_s + f0) / m_s - (f_s + f0 - f_t) / m_us
    f1, m1, _ = evaluate(on, p, w, q[0], v, a1, u, t, 0.0, rate, drive)
    g0 = a1 - a0
    g1 = -(f_s + f1) / m_s - (f_s + f1 - f_t) / m_us - a1
    share = g0 / (g0 - g1) if g0 != g1 else 1.0
    f_d = f0 + share * (f1 - f0)
    f_m = m0 + share * (m1 - m0)
    return -(f_s + f_d) / m_s, (f_s + f_d - f_t) / m_us, f_d, f_m


@njit(error_model="numpy")
def advance(on, slots, passes, p, q, w, duties, lag, t, dt, z_r0, z_r1, n_sub, tolerance):
    """Advance the quarter car by one sample, in place.

    q (4,): z_def, v_s, z_us - z_r, v_us. duties: held values, the newest last, at least as long as the lag.
    """
    n_states = w.shape[0]
    rate = np.zeros(n_states)
    drive = np.zeros(n_states)
    base = np.zeros(n_states)
    q0 = np.empty(4)
    h = dt / n_sub
    gh = GAMMA * h
    road_rate = (z_r1 - z_r0) / dt
    newest = duties.shape[0] - 1
    for i in range(n_sub):
        u = held_mean(duties, newest + i / n_sub - lag, newest + (i + 1) / n_sub - lag)
        for i_j in range(slots.shape[0]):
            j = slots[i_j]
            base[j] = w[j]
        for j in range(4):
            q0[j] = q[j]
        start = q.copy()
        for c in range(2):
            if c == 1:
                for i_j in range(slots.shape[0]):
                    j = slots[i_j]
                    base[j] += (1.0 - GAMMA) / GAMMA * (w[j] - base[j])
                for j in range(4):
                    q0[j] = start[j] + (1.0 - GAMMA) / GAMMA * (q[j] - start[j])
            when = t + (i + (GAMMA if c == 0 else 1.0)) * h
            mechanical_stage(on, slots, passes, p, q0, base, w, q, u, when, gh, road_rate, tolerance, rate, drive)


@njit(cache=True, error_model="numpy")
def start_vehicle(on, slots, at_rest, p, q, w, u, road_rate):
    """Settle the damper's states for a mechanical state q; w is overwritten."""
    rate = np.zeros(w.shape[0])
    drive = np.zeros(w.shape[0])
    settle(on, slots, at_rest, p, w, q[0], q[1] - q[3], 0.0, u, 0.0, 0.0, rate, drive)


@njit(error_model="numpy")
def observe(on, p, q, w, duties, behind, lag, t, road_rate, out):
    """Fill out with accelerations and forces of a state; `behind`: samples since the newest duty began."""
    rate = np.zeros(w.shape[0])
    drive = np.zeros(w.shape[0])
    s = duties.shape[0] - 1 + behind - lag
    u = held_mean(duties, s, s)
    out[0], out[1], out[2], out[3] = accelerations(on, p, w, q, u, t, road_rate, rate, drive)


@njit(cache=True, error_model="numpy")
def step_vehicle(on, slots, passes, p, q, w, duties, t, dt, z_r0, z_r1, n_sub, tolerance, out):
    """One sample of the quarter car, in place; out: a_s, a_us, F_d, measured F at its end."""
    lag = input_delay(on, p) / dt
    advance(on, slots, passes, p, q, w, duties, lag, t, dt, z_r0, z_r1, n_sub, tolerance)
    observe(on, p, q, w, duties, 1.0, lag, t + dt, (z_r1 - z_r0) / dt, out)


@njit(cache=True, error_model="numpy")
def observe_vehicle(on, p, q, w, duties, dt, out):
    """Accelerations and forces of a state at rest on a still road; out: a_s, a_us, F_d, measured F."""
    observe(on, p, q, w, duties, 0.0, input_delay(on, p) / dt, 0.0, 0.0, out)


@njit(cache=True, error_model="numpy")
def simulate_vehicle(on, slots, passes, p, q, w, u, dt, road, n_sub, tolerance, states, outputs):
    """Whole record of the quarter car: states (n, 4) and outputs (n, 4) at each sample."""
    n = road.shape[0]
    depth = 16
    duties = np.empty(depth)
    duties[:] = u[0]
    lag = input_delay(on, p) / dt
    for k in range(n):
        duties[:-1] = duties[1:]
        duties[-1] = u[k]
        rate_k = (road[k + 1] - road[k]) / dt if k + 1 < n else 0.0
        observe(on, p, q, w, duties, 0.0, lag, k * dt, rate_k, outputs[k])
        states[k] = q
        if k + 1 < n:
            advance(on, slots, passes, p, q, w, duties, lag, k * dt, dt, road[k], road[k + 1], n_sub, tolerance)
