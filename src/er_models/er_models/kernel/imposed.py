"""Damper force along an imposed motion: one step after another over a record.

The text below the marker is compiled together with the equations of a catalogue
(`kernel.compose`).
"""

from __future__ import annotations

import math

import numpy as np

from er_models.kernel.elementary import exp
from er_models.kernel.fast import entry, inline, inner, once
from er_models.kernel.inputs import at, cubic, delayed, split
from er_models.kernel.layout import CAUGHT, HEAT, SLIDES
from er_models.kernel.rows import DECAY, LARGEST, ONE, ROWS, SLOPE, W0, G, R, W, Z
from er_models.kernel.states import AT_ONCE, HOLD, keep, settle, solve, visit


def input_delay(on, p):  # type: ignore[no-untyped-def]
    """Composed from the catalogue: delay of the duty [s]."""
    raise NotImplementedError("replaced by kernel.compose")


def output_delay(on, p):  # type: ignore[no-untyped-def]
    """Composed from the catalogue: delay of the measured force [s]."""
    raise NotImplementedError("replaced by kernel.compose")


# --- below this line: compiled with the composed equations ---
FADED = 7.0
"""Time constants of a state after which its beginning no longer shows; within the last of them it is faded out."""
TURN, BEFORE, PAUSE, CLOCK = range(4)
"""Columns of a course (m, 4): which record comes when; of each record the one before it, -1: none, the pause since
that one's end and the time since the first of them began [s]."""
LEAST, MOST, SETTLED, FASTEST, STOP = range(5)
"""Rows of the reach of each state (5, n_states): ends of where it and its equilibria are, where it settled, its
largest rate [1/s], and how far from zero a bound lets it be."""
ASIDE = 1e6
"""Where a state is put to see what drags it back, in its own unit: beyond whatever it can be."""
NOTED, PLAIN = -1, -2
"""In place of a state that is moved away from where it settles: the reach of each is noted, or nothing is."""


@inner
def turning(cut, n_sub):
    """Step of a sample in which the duty changes, for the share of the sample where it does."""
    turn = int(cut * n_sub)
    return turn - 1 if turn / n_sub > cut else turn


@inline
def stops(n_sub, jump, cut, last):
    """How often the equations are looked at in a sample; in the last one only where the duty changes at once."""
    if last:
        return 2 if jump and cut == 0.0 else 0
    return n_sub + 2 if jump else n_sub


@inline
def stop(j, n_sub, turn, cut, u_now, u_next):
    """Where within a sample look j is, and under which duty; the change is looked at before and after."""
    if j < turn:
        return (j + 1) / n_sub, u_now
    if j == turn:
        return cut, u_now
    return (cut if j == turn + 1 else (j - 1) / n_sub), u_next


@inner
def reached(slots, at_rest, s, slowest, reach):
    """Widen the reach of each state by where it is and by its equilibrium, as far as that draws it within a record.

    Where nothing draws it, it is where it may stay; so is what a contact or friction may keep far from what draws it.
    """
    for i in range(slots.shape[0]):
        j = slots[i]
        free = at_rest[j] == CAUGHT or (s[G, j] == 0.0 and s[R, j] == 0.0)
        free = free or (at_rest[j] == SLIDES and s[R, j] < slowest)
        goal = s[W, j] if free else s[G, j] / max(s[R, j], slowest)
        goal = min(max(goal, -reach[STOP, j]), reach[STOP, j])
        reach[LEAST, j] = min(reach[LEAST, j], s[W, j], goal)
        reach[MOST, j] = max(reach[MOST, j], s[W, j], goal)
        reach[FASTEST, j] = max(reach[FASTEST, j], s[R, j])


@once
def dragged(on, slots, links, at_rest, p, s, reach, clock, x, v, a, u, theta):
    """Widen the reach of each state that is dragged along to both ends of the band in which nothing drags it.

    It settles at one of them; what was before the record may have left it anywhere between. Of others the bound is
    noted that keeps them from there. Neither where the other states are nor what their search has learnt stays of these
    looks, which may end beyond all measure.
    """
    rest = s.shape[1] - 1
    largest = s[LARGEST, rest]
    for j in range(s.shape[1]):
        s[DECAY, j], s[ONE, j], s[Z, j] = s[W, j], s[SLOPE, j], math.nan
    for i in range(slots.shape[0]):
        j = slots[i]
        if at_rest[j] != 0:
            continue
        settled = s[W0, j]
        for aside in (-ASIDE, ASIDE):
            s[W0, j] = s[W, j] = aside
            visit(on, links, p, s, 0.0, HOLD, x, v, a, u, clock, theta)
            if s[R, j] >= AT_ONCE and abs(s[W, j]) < ASIDE:
                reach[LEAST, j] = min(reach[LEAST, j], s[W, j])
                reach[MOST, j] = max(reach[MOST, j], s[W, j])
            elif abs(s[W, j]) < ASIDE:
                reach[STOP, j] = abs(s[W, j])
            for other in range(s.shape[1]):
                s[W, other], s[SLOPE, other] = s[DECAY, other], s[ONE, other]
        s[W0, j] = settled
    s[LARGEST, rest] = largest
    visit(on, links, p, s, 0.0, HOLD, x, v, a, u, clock, theta)
    keep(slots, s)


@once
def start(on, slots, links, at_rest, p, s, reach, own, away, clock, warm, x, v, a, u, theta):
    """Settle every state, then move one of them away from there, or note where they settled; measured force [N].

    clock: time since the first of records that follow one another began [s]; warm (n_states,): the heat that is there.
    """
    f_m = settle(on, slots, links, at_rest, p, s, x, v, a, u, theta)
    if clock > 0.0:
        for i in range(slots.shape[0]):
            j = slots[i]
            if at_rest[j] == HEAT:
                s[W, j] = s[W0, j] = warm[j]
    if own >= 0:
        s[W, own] += away
        s[W0, own] = s[W, own]
    if own >= 0 or clock > 0.0:
        _, f_m, _ = visit(on, links, p, s, 0.0, HOLD, x, v, a, u, clock, theta)
        keep(slots, s)
    if own == NOTED:
        for j in range(reach.shape[1]):
            for i in range(FASTEST):
                reach[i, j] = s[W, j]
            reach[FASTEST, j], reach[STOP, j] = 0.0, math.inf
        dragged(on, slots, links, at_rest, p, s, reach, clock, x, v, a, u, theta)
    return f_m


@inner
def predict(
    on, slots, links, at_rest, p, dt, x, v, a, u, theta, n_sub, clock, warm, s, force, reach, own, away, left, path
):  # fmt: skip
    """Measured force [N] over one record of imposed motion, arrays of length n; how many rows were computed.

    The duty is held from each sample on, later by the dead time: a step that it jumps in is cut in two. own: a state
    that begins `away` from where it settles, followed for as long as that shows (`left` (n,), from 1 to 0), or until it
    is where it was when `path` was noted: both came to the same bound, and where they began is forgotten. It fades as
    fast as the slower of both runs: a contact forgets, a gap that is open does not, nor does what both drag along, each
    at an end of its band. What is `CAUGHT` or `SLIDES` fades as both runs come together: its rate leaves out the
    friction. `NOTED`: none, and the reach (5, n_states) and path (n, 2 n_states: states, then rates) of each state are
    noted; `PLAIN`: none.
    """
    n, step = x.shape[0], dt / n_sub
    whole, cut = split(input_delay(on, p) / dt)
    turn = turning(cut, n_sub)
    u_now, faded = u[0], 0.0
    f_m = start(
        on, slots, links, at_rest, p, s, reach, own, away, clock, warm, x[0], v[0], a[0], u_now, theta[0]
    )  # fmt: skip
    force[0] = f_m
    if own >= 0:
        left[0] = 1.0
    for k in range(n):
        m = min(k + 1, n - 1)
        u_next = u[max(k - whole, 0)]
        jump = u_now != u_next
        x_k, v_k = cubic(x[k], v[k], x[m], v[m], dt), cubic(v[k], a[k], v[m], a[m], dt)
        a_rise, theta_rise = a[m] - a[k], theta[m] - theta[k]
        h, end = step, 0.0
        for j in range(stops(n_sub, jump, cut, m == k)):
            q = (j + 1) / n_sub
            if jump:
                q, u_now = stop(j, n_sub, turn, cut, u_now, u_next)
                h, end = (q - end) * dt, q
            _, f_m, _ = solve(
                on, links, p, s, h, HOLD, at(x_k, q), at(v_k, q), a[k] + q * a_rise, u_now,
                clock + (k + q) * dt, theta[k] + q * theta_rise,
            )  # fmt: skip
            keep(slots, s)
            if jump and q == 0.0:
                force[k] = f_m
        if m > k:
            force[m] = f_m
            if own == NOTED:
                reached(slots, at_rest, s, 1.0 / (n * dt), reach)
                for i in range(slots.shape[0]):
                    path[m, slots[i]] = s[W, slots[i]]
                    path[m, slots[i] + s.shape[1]] = s[R, slots[i]]
            if own < 0:
                continue
            if at_rest[own] == CAUGHT or at_rest[own] == SLIDES:
                apart = abs((s[W, own] - path[m, own]) / away)
                faded = max(faded, -math.log(apart)) if apart > 0.0 else FADED
            else:
                slower = min(s[R, own], path[m, own + s.shape[1]])
                faded += dt * slower if slower < AT_ONCE else 0.0
            if not faded < FADED or s[W, own] == path[m, own]:
                return m
            left[m] = min(FADED - faded, 1.0)
    return n


@inner
def late(force, shift, raw):
    """Delay a record (n,) by so many samples; raw (n,): scratch."""
    if shift != 0.0 and force.shape[0] > 1:
        for k in range(force.shape[0]):
            raw[k] = force[k]
        delayed(raw, shift, force)


@inner
def cooled(course, r, ends, warm):
    """Heat (n_states,) with which record r begins: that of the one before it, after the pause."""
    before = int(course[r, BEFORE])
    for j in range(warm.shape[0]):
        warm[j] = 0.0
        if before >= 0:
            warm[j] = ends[before, 0, j] * exp(-ends[before, 1, j] * course[r, PAUSE])


@inner
def ended(s, r, ends):
    """Note states and rates at the end of record r."""
    for j in range(s.shape[1]):
        ends[r, 0, j], ends[r, 1, j] = s[W, j], s[R, j]


@entry
def predict_rows(
    on, slots, links, at_rest, ps, dt, starts, course, x, v, a, u, theta, n_sub, forces
):
    """One prediction per row of `ps` (m, n_parameters) into `forces` (m, n).

    Several records are laid end to end; `starts` holds their first rows and the end, `course` how they follow one
    another (`prediction.Motion`).
    """
    s, many = np.empty((ROWS, at_rest.shape[0])), starts.shape[0] - 1
    ends, warm = np.empty((many, 2, at_rest.shape[0])), np.empty(at_rest.shape[0])
    plain = PLAIN + 0 * many  # a bare number is a type to Numba, as in `slopes`
    for k in range(ps.shape[0]):
        p, force = ps[k], forces[k]
        shift = output_delay(on, p) / dt
        for q in range(many):
            r = int(course[q, TURN])
            i, j = starts[r], starts[r + 1]
            cooled(course, r, ends, warm)
            predict(
                on, slots, links, at_rest, p, dt, x[i:j], v[i:j], a[i:j], u[i:j], theta[i:j], n_sub, course[r, CLOCK],
                warm, s, force[i:j], s, plain, 0.0, force[i:j], s,
            )  # fmt: skip
            ended(s, r, ends)
            if shift != 0.0:
                late(force[i:j], shift, np.empty(j - i))


@entry
def damper_point(on, links, p, s, x, v, a, u, t, theta):
    """Forces and duty at one instant with the states s[W]; fills rates and drives. For `rhs`."""
    return visit(on, links, p, s, 0.0, HOLD, x, v, a, u, t, theta)


@entry
def settle_point(on, slots, links, at_rest, p, s, x, v, a, u, theta):
    """States s[W] in equilibrium with a motion, except those that start at rest; measured force [N].

    Where `predict` begins: a reference solution of the same record must begin there too.
    """
    return settle(on, slots, links, at_rest, p, s, x, v, a, u, theta)
