r"""The quarter car with its damper: stiff, so every stage is implicit.

Both stages of the L-stable, stiffly accurate SDIRK2 method (Alexander 1977, gamma = 1 - 1/sqrt 2)
are solved for one unknown, the deflection velocity: the damper force reacts to it within
microseconds (the tanh of a static model), all else follows in straight lines. The miss of a trial
velocity grows with it, so a secant kept in brackets always arrives.

The text below the marker is compiled together with the equations of a catalogue
(`kernel.compose`).
"""

from __future__ import annotations

import math

import numpy as np

from er_models.kernel.fast import entry, inline, inner
from er_models.kernel.imposed import input_delay
from er_models.kernel.inputs import split
from er_models.kernel.rows import ROWS, SLOPE, W0, G, R, W
from er_models.kernel.sensors import accelerometers, remember_force, remember_velocity, report
from er_models.kernel.states import HOLD, STAGE, settle, visit


def chassis(on, p, x, v, z_t, v_t, v_s):  # type: ignore[no-untyped-def]
    """Composed from the catalogue: spring force, tyre force and masses."""
    raise NotImplementedError("replaced by kernel.compose")


# --- below this line: compiled with the composed equations ---
GAMMA = 1.0 - 1.0 / math.sqrt(2.0)
AGAIN = (1.0 - GAMMA) / GAMMA
"""How much of the first stage's change is in the base of the second."""
TRIALS = 60


@inline
def bodies(on, p, q0, q, v, f_d, h, road_rate, tolerance):
    """Velocities of both masses at the end of a stage, for its damper force; the tyre is solved by a secant."""
    at, miss = q[3], 0.0
    for i in range(TRIALS):
        q[2] = q0[2] + h * (q[3] - road_rate)
        f_s, f_t, m_s, m_us = chassis(on, p, q[0], v, q[2], q[3] - road_rate, q[1])
        q[1] = q0[1] - h * (f_s + f_d) / m_s
        ahead = q0[3] + h * (f_s + f_d - f_t) / m_us - q[3]
        if not abs(ahead) > 1e-3 * tolerance:
            break
        if i > 0 and q[3] != at:
            q0[4] = max((miss - ahead) / (q[3] - at), 0.5)
        at, miss = q[3], ahead
        q[3] += ahead / q0[4]


@inline
def stage(on, links, p, q0, s, q, v, slope, u, t, h, beside, road_rate, tolerance):
    """Solve one implicit stage of length h from the velocity v on, q and s in place; beside: force beside the damper.

    Returns the slope of the miss and the measured force.
    """
    low, high = -math.inf, math.inf
    v_last, miss_last, f_m = v, 0.0, 0.0
    for i in range(TRIALS):
        q[0] = q0[0] + h * v
        a = (v - (q0[1] - q0[3])) / h
        f_d, f_m, _ = visit(on, links, p, s, h, STAGE, q[0], v, a, u, t, 0.0)
        bodies(on, p, q0, q, v, f_d + beside, h, road_rate, tolerance)
        miss = v - (q[1] - q[3])
        if not abs(miss) > tolerance:
            break
        if miss > 0.0:
            high = v
        else:
            low = v
        if i > 0 and v != v_last:
            slope = max((miss - miss_last) / (v - v_last), 0.5)
        v_last, miss_last = v, miss
        v -= miss / slope
        if not low < v < high:
            v = 0.5 * (low + high) if low > -math.inf and high < math.inf else v_last - miss
    return slope, f_m


@inner
def step(
    on, slots, links, p, q, q0, s, slope, rate, u, t, h, beside, change, road_rate, tolerance
):
    """One SDIRK2 step of length h, in place; rate: acceleration to begin with.

    beside: force beside the damper at the start of the step [N]; change: by how much it differs at the end.

    Returns slope and rate for the next step, and the measured force.
    """
    for j in range(4):
        q0[j] = q[j]
    for i in range(slots.shape[0]):
        s[W0, slots[i]] = s[W, slots[i]]
    gh, f_m = GAMMA * h, 0.0
    for c in range(2):
        if c == 1:
            for j in range(4):
                q0[j] += AGAIN * (q[j] - q0[j])
            for i in range(slots.shape[0]):
                s[W0, slots[i]] += AGAIN * (s[W, slots[i]] - s[W0, slots[i]])
        base = q0[1] - q0[3]
        part = GAMMA if c == 0 else 1.0
        slope, f_m = stage(
            on, links, p, q0, s, q, base + gh * rate, slope, u, t + (gh if c == 0 else h), gh,
            beside + part * change, road_rate, tolerance,
        )  # fmt: skip
        rate = (q[1] - q[3] - base) / gh
    return slope, rate, f_m


@inner
def sample(
    on,
    slots,
    links,
    p,
    q,
    q0,
    s,
    u_0,
    u_1,
    cut,
    t,
    dt,
    n_sub,
    road,
    first,
    lines,
    beside,
    change,
    tolerance,
    reading,
    memory,
):
    """One sample of the quarter car, in place: the duty is u_0 until the share `cut` of the sample, then u_1.

    The road goes on from its node `first` in so many straight lines, the force beside the damper in one.

    Nothing is remembered from the sample before but q, the states and the sensors' memory, so that
    a record can be cut anywhere.
    """
    slope, rate, end = 1.0, 0.0, 0.0
    q0[4] = 1.0
    for i in range(links.shape[0]):
        s[SLOPE, links[i]] = 0.0
    for i in range(n_sub):
        goal = (i + 1) / n_sub
        node = first + i * lines // n_sub
        road_rate = (road[node + 1] - road[node]) * lines / dt
        for piece in range(0 if u_0 != u_1 and end < cut < goal else 1, 2):
            q_end = cut if piece == 0 else goal
            u = u_1 if end >= cut else u_0
            h, v = (q_end - end) * dt, q[1] - q[3]
            slope, rate, f_m = step(
                on,
                slots,
                links,
                p,
                q,
                q0,
                s,
                slope,
                rate,
                u,
                t + end * dt,
                h,
                beside + end * change,
                (q_end - end) * change,
                road_rate,
                tolerance,
            )
            remember_velocity(reading, memory, v, q[1] - q[3], h)
            end = q_end
        remember_force(memory, f_m)


@inner
def observe(on, slots, links, p, q, s, u, t, beside, road_rate, out, k):
    """Fill row k of out with both accelerations [m/s2], true and measured force [N] of a state; rates of s in place.

    The damper force may depend on the acceleration (fluid inertia) in a straight line: two trials
    find it.
    """
    for i in range(slots.shape[0]):
        s[W0, slots[i]] = s[W, slots[i]]
    v = q[1] - q[3]
    f_s, f_t, m_s, m_us = chassis(on, p, q[0], v, q[2], q[3] - road_rate, q[1])
    a, a_last, ahead_last = 0.0, 0.0, 0.0
    for i in range(3):
        f_d, f_m, _ = visit(on, links, p, s, 0.0, HOLD, q[0], v, a, u, t, 0.0)
        f = f_d + beside
        a_s, a_us = -(f_s + f) / m_s, (f_s + f - f_t) / m_us
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = a_s, a_us, f_d, f_m
        ahead = a_s - a_us - a
        if i == 0:
            a_last, ahead_last, a = a, ahead, a + ahead
        elif i == 1 and ahead != ahead_last:
            a -= ahead * (a - a_last) / (ahead - ahead_last)


@inline
def duty_at(past, u, k):
    """Duty held from sample k on, before the record from those remembered."""
    return u[k] if k >= 0 else past[max(past.shape[0] + k, 0)]


@entry
def start_vehicle(on, slots, links, at_rest, p, q, w, u):
    """Settle the damper's states w for a mechanical state q; returns the measured force."""
    s = np.empty((ROWS, w.shape[0]))
    f_m = settle(on, slots, links, at_rest, p, s, q[0], q[1] - q[3], 0.0, u, 0.0)
    for j in range(w.shape[0]):
        w[j] = s[W, j]
    return f_m


@entry
def vehicle_point(on, slots, links, p, q, w, u, t, beside, road_rate, rate, drive, out):
    """Accelerations and forces of a state, the reported accelerations, and rate and drive of every damper state.

    beside: force between the masses beside the damper [N], positive where it resists extension.
    """
    s = np.zeros((ROWS, w.shape[0]))
    for j in range(w.shape[0]):
        s[W, j] = w[j]
    first = 0 * out.shape[0]  # a bare number is a type to Numba: `observe` would be compiled twice
    observe(on, slots, links, p, q, s, u, t, beside, road_rate, out, first)
    out[0, 4], out[0, 5] = accelerometers(on, p, out[0, 0], out[0, 1])
    for j in range(w.shape[0]):
        rate[j], drive[j] = s[R, j], s[G, j]


@entry
def run_vehicle(
    on,
    slots,
    links,
    p,
    q,
    w,
    past,
    u,
    t,
    dt,
    road,
    rates,
    beside,
    n_sub,
    tolerance,
    ahead,
    reading,
    memory,
    states,
    outputs,
):
    """The quarter car over n samples, in place, from q, w and the sensors' memory on.

    past: duties before, newest last, as many as the dead time needs. u: held from each sample on.
    road (lines n + 1,), in straight lines of equal length; rates (n,): of the road, as the outputs
    at the end of each sample see it. beside (n + 1,): force beside the damper at each sample and at the end, straight
    between. ahead: whether these see the duty of the next sample (a record, u (n + 1,)) or
    not yet (a plant, u (n,)). Fills states (n, 4) with q, and outputs (n, 6) with both
    accelerations, true and measured force, reported deflection and velocity, all at the end of
    each sample.
    """
    n, n_states = states.shape[0], w.shape[0]
    s = np.zeros((ROWS, n_states))
    q0 = np.empty(5)
    for j in range(n_states):
        s[W, j] = w[j]
    whole, cut = split(input_delay(on, p) / dt)
    lines = (road.shape[0] - 1) // max(n, 1)
    for k in range(n):
        before, now = duty_at(past, u, k - whole - 1), duty_at(past, u, k - whole)
        sample(
            on, slots, links, p, q, q0, s, before, now, cut, t, dt, n_sub, road, k * lines, lines,
            beside[k], beside[k + 1] - beside[k], tolerance, reading, memory,
        )  # fmt: skip
        t += dt
        if ahead:
            now = duty_at(past, u, k + 1 - whole) if cut == 0.0 else now
        observe(on, slots, links, p, q, s, now, t, beside[k + 1], rates[k], outputs, k)
        report(on, p, q, reading, memory, dt / n_sub, outputs, k)
        for j in range(4):
            states[k, j] = q[j]
    for j in range(n_states):
        w[j] = s[W, j]
