r"""Four corners below one rigid body, coupled by its mass and the anti-roll bars: implicit as one corner is.

Each corner of a sample is a quarter car whose sprung mass is what the body opposes there. What the other
corners do to the body reaches it as a velocity. One corner after the other is solved with `kernel.vehicle`'s stage
until none moves any more (Gauss-Seidel). That always ends: the body's compliance is symmetric and positive definite,
and a damper force never falls with its velocity faster than the stage can follow.

Corners: front left, front right, rear left, rear right. The text below the marker is compiled together with the
equations of a catalogue (`kernel.compose`).
"""

from __future__ import annotations

import numpy as np

from er_models.kernel.fast import entry, inner
from er_models.kernel.imposed import input_delay
from er_models.kernel.inputs import split
from er_models.kernel.rows import ROWS, SLOPE, W0, W
from er_models.kernel.sensors import remember_force, remember_velocity, report
from er_models.kernel.states import HOLD, visit
from er_models.kernel.vehicle import AGAIN, GAMMA, chassis, duty_at, stage

# --- below this line: compiled with the composed equations ---
CORNERS = 4
ROUNDS = 60


@inner
def from_others(body, push, down, i):
    """Acceleration of the body at a corner by loads and by what presses at the other corners."""
    a = push[i]
    for j in range(CORNERS):
        if j != i:
            a -= body[i, j] * down[j]
    return a


@inner
def car_stage(
    on,
    links,
    p,
    q0,
    s,
    q,
    v,
    slope,
    body,
    bars,
    wheels,
    push,
    down,
    f_m,
    u,
    t,
    h,
    rates,
    tolerance,
):
    """Solve one implicit stage of length h of all corners, in place; down: what presses on the body [N]."""
    own = q0[CORNERS]
    for _ in range(ROUNDS):
        moved = 0.0
        for i in range(CORNERS):
            bar = bars[i] * (q[i, 0] - q[i ^ 1, 0])
            own[0], own[2], own[4] = q0[i, 0], q0[i, 2], q0[i, 4]
            own[1] = q0[i, 1] + h * (from_others(body, push, down, i) - body[i, i] * bar)
            own[3] = q0[i, 3] + h * bar / wheels[i]
            before = v[i]
            slope[i], f_m[i] = stage(
                on[i],
                links[i],
                p[i],
                own,
                s[i],
                q[i],
                before,
                slope[i],
                u[i],
                t,
                h,
                0.0,
                rates[i],
                tolerance,
            )
            q0[i, 4] = own[4]
            v[i] = q[i, 1] - q[i, 3]
            down[i] = bar + (own[1] - q[i, 1]) / (h * body[i, i])
            moved = max(moved, abs(v[i] - before))
        if not moved > tolerance:
            break


@inner
def car_step(
    on,
    slots,
    links,
    p,
    q0,
    s,
    q,
    v,
    slope,
    rate,
    body,
    bars,
    wheels,
    push,
    down,
    f_m,
    u,
    t,
    h,
    rates,
    tolerance,
):
    """One SDIRK2 step of length h of all corners, in place; rate (4,): deflection accelerations to begin with."""
    for i in range(CORNERS):
        for j in range(4):
            q0[i, j] = q[i, j]
        for j in range(slots[i].shape[0]):
            s[i, W0, slots[i][j]] = s[i, W, slots[i][j]]
    gh = GAMMA * h
    for c in range(2):
        for i in range(CORNERS):
            if c == 1:
                for j in range(4):
                    q0[i, j] += AGAIN * (q[i, j] - q0[i, j])
                for j in range(slots[i].shape[0]):
                    k = slots[i][j]
                    s[i, W0, k] += AGAIN * (s[i, W, k] - s[i, W0, k])
            v[i] = q0[i, 1] - q0[i, 3] + gh * rate[i]
        when = t + (gh if c == 0 else h)
        car_stage(
            on,
            links,
            p,
            q0,
            s,
            q,
            v,
            slope,
            body,
            bars,
            wheels,
            push,
            down,
            f_m,
            u,
            when,
            gh,
            rates,
            tolerance,
        )
        for i in range(CORNERS):
            rate[i] = (q[i, 1] - q[i, 3] - (q0[i, 1] - q0[i, 3])) / gh


@inner
def car_observe(
    on,
    slots,
    links,
    p,
    q,
    s,
    u,
    t,
    rates,
    body,
    bars,
    wheels,
    push,
    down,
    a,
    close,
    outputs,
    true,
    k,
):
    """Fill row k of outputs with accelerations and forces of a state, and of true with the body's at the corners."""
    for i in range(CORNERS):
        for j in range(slots[i].shape[0]):
            s[i, W0, slots[i][j]] = s[i, W, slots[i][j]]
    for _ in range(ROUNDS):
        moved = 0.0
        for i in range(CORNERS):
            v = q[i, 1] - q[i, 3]
            f_s, f_t, _, _ = chassis(on[i], p[i], q[i, 0], v, q[i, 2], q[i, 3] - rates[i], q[i, 1])
            bar = bars[i] * (q[i, 0] - q[i ^ 1, 0])
            around, before, a_last, ahead_last = from_others(body, push, down, i), a[i], 0.0, 0.0
            for trial in range(3):
                f_d, f_m, _ = visit(
                    on[i], links[i], p[i], s[i], 0.0, HOLD, q[i, 0], v, a[i], u[i], t, 0.0
                )
                down[i] = f_s + f_d + bar
                a_s, a_us = around - body[i, i] * down[i], (down[i] - f_t) / wheels[i]
                out = outputs[i]
                out[k, 0], out[k, 1], out[k, 2], out[k, 3], true[k, i] = a_s, a_us, f_d, f_m, a_s
                ahead = a_s - a_us - a[i]
                if trial == 0:
                    a_last, ahead_last, a[i] = a[i], ahead, a[i] + ahead
                elif trial == 1 and ahead != ahead_last:
                    a[i] -= ahead * (a[i] - a_last) / (ahead - ahead_last)
            moved = max(moved, abs(a[i] - before))
        if not moved > close:
            break


@inner
def anew(links, q0, s, slope, rate, down, a):
    """Forget what a sample before led to: a record can be cut anywhere."""
    for i in range(CORNERS):
        slope[i], rate[i], down[i], a[i], q0[i, 4] = 1.0, 0.0, 0.0, 0.0, 1.0
        for j in range(links[i].shape[0]):
            s[i, SLOPE, links[i][j]] = 0.0


@inner
def driven(on, p, past, u, k, share, dt, n_sub, now):
    """Duties in force in sample k from a share of it on; a dead time ends at the nearest substep."""
    for i in range(CORNERS):
        whole, cut = split(input_delay(on[i], p[i]) / dt)
        now[i] = duty_at(
            past[i], u[i], k - whole - (1 if share < round(cut * n_sub) / n_sub else 0)
        )


@inner
def hear(on, p, q, reading, memory, h, states, outputs, k):
    """Fill row k of outputs with what the sensors say, and of states with q."""
    for i in range(CORNERS):
        report(on[i], p[i], q[i], reading[i], memory[i], h, outputs[i], k)
        for j in range(4):
            states[k, i, j] = q[i, j]


@entry
def run_car(
    on, slots, links, p, q, w, past, u, t, dt, road, rates, n_sub, tolerance, reading, memory, body, bars, wheels, push,
    states, outputs, true,
):  # fmt: skip
    """The car over n samples, in place, from q (4, 4), w and the sensors' memories on; a tuple has one array a corner.

    past: duties before, newest last. u (4, n): duty held during each sample; a change within a sample, as after a dead
    time, acts from the nearest substep on. road (4, lines n + 1): in straight lines of equal length; rates (4, n): of
    the road, as the outputs see it. body (4, 4): compliance J M^-1 J' [1/kg]; bars (4,): stiffness of the anti-roll bar
    [N/m]; wheels (4,): unsprung masses [kg]; push (n, 4): acceleration by loads on the body [m/s2]. Fills states
    (n, 4, 4), outputs with (n, 6) a corner, as `run_vehicle`, and true (n, 4): acceleration of the body at the corners.
    """
    n, h = states.shape[0], dt / n_sub
    lines = (road.shape[1] - 1) // max(n, 1)
    s = np.zeros((CORNERS, ROWS, w[0].shape[0]))
    for i in range(CORNERS):
        for j in range(w[i].shape[0]):
            s[i, W, j] = w[i][j]
    q0, v, slope, rate = np.zeros((CORNERS + 1, 5)), np.zeros(4), np.zeros(4), np.zeros(4)
    down, f_m, a, now = np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(4)
    street, before = np.zeros(4), np.zeros(4)
    for k in range(n):
        anew(links, q0, s, slope, rate, down, a)
        for m in range(n_sub):
            node = k * lines + m * lines // n_sub
            driven(on, p, past, u, k, m / n_sub, dt, n_sub, now)
            for i in range(CORNERS):
                street[i] = (road[i, node + 1] - road[i, node]) * lines / dt
                before[i] = q[i, 1] - q[i, 3]
            car_step(
                on, slots, links, p, q0, s, q, v, slope, rate, body, bars, wheels, push[k], down, f_m, now, t + m * h,
                h, street, tolerance,
            )  # fmt: skip
            for i in range(CORNERS):
                remember_velocity(reading[i], memory[i], before[i], q[i, 1] - q[i, 3], h)
                remember_force(memory[i], f_m[i])
        t += dt
        for i in range(CORNERS):
            street[i] = rates[i, k]
        car_observe(
            on, slots, links, p, q, s, now, t, street, body, bars, wheels, push[k], down, a, tolerance / dt, outputs,
            true, k,
        )  # fmt: skip
        hear(on, p, q, reading, memory, h, states, outputs, k)
    for i in range(CORNERS):
        for j in range(w[i].shape[0]):
            w[i][j] = s[i, W, j]
