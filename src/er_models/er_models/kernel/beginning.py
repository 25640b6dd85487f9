"""Where the states of a record begin, as its measured force says.

A state that relaxes stays between the equilibria that its motion asks for, so that is where it may have begun:
somewhere on the way from where it would have settled to the farther end of them, or short of the nearer one. Its prior
is normal about where it would have settled, with that way as its deviation. The force follows a beginning in a straight
line. Its slope is how the force differs when the record is run again from the farther end, in steps of a whole sample,
for as long as that shows: a few time constants of the state, or until a bound stops it in both runs. The shares of all
ways that meet the measured force best are those of least squares. A state that is dragged along (`remanence`), that
slides once it is bent enough (`bouc_wen_hysteresis`), or that a contact or the friction behind a joint may catch
anywhere (`freeplay`, `friction_with_play`), follows no straight line: it is run again from where it was found to begin,
and the slope is that of the chord to there, until both agree. A gap has more than one valley, so that several
beginnings are looked at first. A long rest before the motion begins is not run through again for these: nothing moves
in it, and its force shows the beginning throughout.

Source: separable least squares, Golub and Pereyra 1973.

The text below the marker is compiled together with the equations of a catalogue
(`kernel.compose`).
"""

from __future__ import annotations

import math

import numpy as np

from er_models.kernel.fast import entry, inner, once
from er_models.kernel.imposed import (
    CLOCK,
    FASTEST,
    LEAST,
    MOST,
    NOTED,
    PLAIN,
    SETTLED,
    TURN,
    cooled,
    ended,
    late,
    output_delay,
    predict,
)
from er_models.kernel.layout import CAUGHT, HEAT, SLIDES, ZERO
from er_models.kernel.rows import ROWS, R, W
from er_models.kernel.states import AT_ONCE

# --- below this line: compiled with the composed equations ---
BEYOND_MEASURE = 1e100
"""A force [N] as large is none: sums of the squares of larger ones are no numbers."""
TURNS = 40
"""Turns through the states in which the shares of their ways are found, one after the other."""
CHORDS, NEARBY = 4, 1
"""How often the chord of a state that is no straight line is drawn again, at most, and where there is a hint."""
LOOKS, HALVINGS = 4, 3
"""Beginnings of such a state that are looked at first, from the far end of its reach to the near one, and how often
both sides of the best one are looked at, each time half as far off."""
SPAN = 2
"""How much longer they are looked at than it takes the state to go through its way."""
STILL = 0.05
"""Share of its way below which a state that is dragged along is not moved by a record."""
MOVED = 0.02
"""Share of its way by which the beginning of a state must have moved for that."""
STILL_MOTION, STILL_DUTY = 0.005, 0.02
"""Shares of the stroke and of the largest duty of a record within which it rests."""
LONG, RESTS, WATCHED, SETTLING = 200, 0.25, 100, 3
"""Rows of a rest that need not be run through again, share of its way within which a state rests, rows in which it
shows whether it does so away from where it settles, and rows until what it moves has come to rest."""


@inner
def way(reach, j):
    """Way of a state from where it settles to the far end of its reach; the near end as a share of that way."""
    up, down = reach[MOST, j] - reach[SETTLED, j], reach[SETTLED, j] - reach[LEAST, j]
    if up > down:
        return up, -down / up
    return -down, -up / down if down > 0.0 else 0.0


@inner
def slope(shown, settled, left, share, first, shift, raw):
    """Make of the run (n,) of a state from a share of its way what it adds to the settled run (n,), over the share.

    Both begin at row `first`, until shortly after which nothing moves; left (n,): how much of the beginning shows. A
    run that grows beyond measure (a negative field makes a damping negative) tells nothing.
    """
    n, told = shown.shape[0], True
    for k in range(first, n):
        shown[k] = (shown[k] - settled[k]) * left[k] / share
        told = told and abs(shown[k]) < BEYOND_MEASURE
    rested = min(first + SETTLING, n - 1) if first > 0 else 0
    for k in range(rested):
        shown[k], left[k] = shown[rested], left[rested]
    if not told:
        for k in range(n):
            shown[k] = left[k] = 0.0
    late(shown, shift, raw)


@inner
def rest(x, u):
    """Row with which the rest ends that a record begins with: neither motion nor duty change until there."""
    low = high = x[0]
    most = 0.0
    for k in range(x.shape[0]):
        low, high, most = min(low, x[k]), max(high, x[k]), max(most, abs(u[k]))
    for k in range(1, x.shape[0]):
        if abs(x[k] - x[0]) > STILL_MOTION * (high - low) or abs(u[k] - u[0]) > STILL_DUTY * most:
            return k - 1
    return 0


@inner
def rests(own, path, away, n):
    """First row, of n, from which on a state is on its way."""
    for k in range(1, n):
        if abs(path[k, own] - path[1, own]) > RESTS * abs(away):
            return k - 1
    return n


@inner
def lies(own, at_rest, s, reach, away, path, n):
    """Whether a state that is dragged along lies still in a record of n rows, from where it settles and from far away.

    s: at the end of the run from there. All that its beginning shows then is an offset, which may have any cause.
    """
    if at_rest[own] != 0 or reach[FASTEST, own] < AT_ONCE:
        return False
    low = high = path[n - 1, own]
    for k in range(1, n):
        low, high = min(low, path[k, own]), max(high, path[k, own])
    most = max(high - low, abs(s[W, own] - (reach[SETTLED, own] + away)))
    return most < STILL * abs(away)


@inner
def looked_for(at_rest, own, hint):
    """Whether a state may be caught anywhere, and nobody knows yet about where."""
    return at_rest[own] == CAUGHT and math.isnan(hint[own])


@once
def shifted(
    on, slots, links, at_rest, p, dt, x, v, a, u, theta, clock, warm, s, reach, own, away, first, shown, left, path
):  # fmt: skip
    """Run a state from `away` of where it settles, from row `first` on, in steps of whole samples; how far it shows.

    own: the state; `PLAIN`: none, all settle. left (n,): how much of the beginning shows, nothing where it ends.
    """
    # a bare number is a type to Numba: `predict` would be compiled for each
    n_sub = 1 + 0 * x.shape[0]
    seen = first + predict(
        on, slots, links, at_rest, p, dt, x[first:], v[first:], a[first:], u[first:], theta[first:], n_sub, clock, warm,
        s, shown[first:], reach, own, away, left[first:], path[first:],
    )  # fmt: skip
    for k in range(seen, x.shape[0]):
        shown[k] = left[k] = 0.0
    return seen


@once
def begins(
    on, slots, links, at_rest, p, dt, x, v, a, u, theta, clock, warm, s, reach, own, away, still, shown, left, path
):  # fmt: skip
    """Row shortly before a state is on its way, be it from where it settles or from `away` of there; else zero.

    still: row until which motion and duty rest. What is dragged along rests never, since it forgets nothing; nor what
    relaxes, but where friction catches it. Some rows of the rest show whether the runs come together. It must settle
    there as it did when the record began.
    """
    first = rests(own, path, away, still) - SETTLING
    if first < LONG or reach[FASTEST, own] >= AT_ONCE:
        return 0
    seen = shifted(
        on, slots, links, at_rest, p, dt, x[:WATCHED], v[:WATCHED], a[:WATCHED], u[:WATCHED], theta[:WATCHED], clock,
        warm, s, reach, own, away, 0 * first, shown, left, path,
    )  # fmt: skip
    apart = s[W, own] - path[WATCHED - 1, own]
    moved = abs(apart - (reach[SETTLED, own] + away - path[1, own])) / abs(away)
    if seen < WATCHED or moved > RESTS or (at_rest[own] != CAUGHT and s[R, own] > 0.0):
        return 0
    shifted(
        on, slots, links, at_rest, p, dt, x[: first + 1], v[: first + 1], a[: first + 1], u[: first + 1],
        theta[: first + 1], clock, warm, s, reach, PLAIN + 0 * first, 0.0, first, shown, left, path,
    )  # fmt: skip
    return first if abs(s[W, own] - reach[SETTLED, own]) < RESTS * abs(away) else 0


@once
def slopes(
    on, slots, links, at_rest, p, dt, x, v, a, u, theta, clock, warm, s, reach, shift, hint, same, shown, plain, left,
    near, drawn, first, raw, path,
):  # fmt: skip
    """How the force follows the beginning of each state over its way: shown (S, n) [N]; how many rows show it.

    States that begin at zero are counted from there. hint (n_states,): shares near which states were found to begin,
    NaN where nobody knows; same: the last row of shown (S + 1, n) is the run from where all settle already; plain
    (S, n): that run beside each state, from the row `first` (S,) on from which it rests no longer; near (S,): the near
    ends, and drawn (S,): those that the slopes go to, as shares; path (n, 2 n_states): where they were when reach was
    noted, and their rates; left (S, n), raw (n,): scratch.
    """
    many, n, rows, whole = slots.shape[0], x.shape[0], 0, same
    settled, still = PLAIN + rows, rest(x, u)
    for q in range(many):
        own, seen, drawn[q], first[q] = slots[q], 0, 1.0, 0
        away, near[q] = way(reach, own)
        anywhere = looked_for(at_rest, own, hint)
        if at_rest[own] == CAUGHT and not anywhere:
            drawn[q] = min(max(hint[own], near[q]), 1.0)
        if at_rest[own] != ZERO and at_rest[own] != HEAT and away != 0.0:
            first[q] = begins(
                on, slots, links, at_rest, p, dt, x, v, a, u, theta, clock, warm, s, reach, own, away, still, shown[q],
                left[q], path,
            )  # fmt: skip
            if anywhere and near[q] < 0.0:
                rows = max(rows, shifted(
                    on, slots, links, at_rest, p, dt, x, v, a, u, theta, clock, warm, s, reach, own, near[q] * away,
                    first[q], shown[q], left[q], path,
                ))  # fmt: skip
            seen = shifted(
                on, slots, links, at_rest, p, dt, x, v, a, u, theta, clock, warm, s, reach, own, drawn[q] * away,
                first[q], shown[q], left[q], path,
            )  # fmt: skip
        if seen == 0 or lies(own, at_rest, s, reach, away, path, n):
            seen = first[q] = 0
        for k in range(seen, n):
            shown[q, k] = left[q, k] = 0.0
        rows = max(rows, seen)
    for q in range(many):
        if left[q, first[q]] == 0.0:
            continue
        if first[q] == 0 and not whole:
            shifted(
                on, slots, links, at_rest, p, dt, x[:rows], v[:rows], a[:rows], u[:rows], theta[:rows], clock, warm, s,
                reach, settled, 0.0, first[q], shown[many, :rows], raw, path,
            )  # fmt: skip
            whole = True
        if first[q] > 0:
            shifted(
                on, slots, links, at_rest, p, dt, x[:rows], v[:rows], a[:rows], u[:rows], theta[:rows], clock, warm, s,
                reach, settled, 0.0, first[q], plain[q, :rows], raw, path,
            )  # fmt: skip
        else:
            for k in range(rows):
                plain[q, k] = shown[many, k]
        slope(
            shown[q, :rows], plain[q, :rows], left[q, :rows], drawn[q], first[q], shift, raw[:rows]
        )
    return rows


@inner
def crooked(reach, at_rest, own):
    """Whether the force follows no straight line: the state is dragged along, or a contact or friction catches it."""
    return reach[FASTEST, own] >= AT_ONCE or at_rest[own] == CAUGHT or at_rest[own] == SLIDES


@inner
def missed(error, weight, shown, share, q):
    """Weighted squares of what the shares leave, with the prior of that of state q."""
    total = share[q] * share[q]
    for k in range(error.shape[0]):
        rest = error[k]
        for other in range(share.shape[0]):
            rest -= share[other] * shown[other, k]
        total += weight[k] * rest * rest
    return total


@inner
def aim(look, near, best):
    """Share that is looked at: from the far end to the near one, then about the best one, half as far off each time."""
    if look < LOOKS:
        return 1.0 - (1.0 - near) * look / (LOOKS - 1)
    off = (1.0 - near) / (LOOKS - 1) * 0.5 ** ((look - LOOKS) // 2 + 1)
    return min(max(best + off * (1.0 - 2.0 * ((look - LOOKS) % 2)), near), 1.0)


@inner
def stays(to, drawn):
    """Share of a state that is not drawn again: that of its chord, where the straight line would lead farther off."""
    return to if abs(to - drawn) < MOVED else drawn


@once
def chord(
    on, slots, links, at_rest, p, dt, x, v, a, u, theta, clock, warm, s, reach, shift, shown, plain, left, first, q, to,
    raw, path,
):  # fmt: skip
    """Draw into `shown` the chord of state q to the share `to` of its way, over the rows of the motion."""
    n, (away, _) = x.shape[0], way(reach, slots[q])
    shifted(
        on, slots, links, at_rest, p, dt, x, v, a, u, theta, clock, warm, s, reach, slots[q], to * away, first[q],
        shown[q, :n], left[q, :n], path,
    )  # fmt: skip
    slope(shown[q, :n], plain[q, :n], left[q, :n], to, first[q], shift, raw[:n])


@inner
def crossed(path, own, away, n):
    """Rows of a record of n in which a state goes through as much as its way, from where all settle."""
    low = high = path[min(1, n - 1), own]
    for k in range(1, n):
        low, high = min(low, path[k, own]), max(high, path[k, own])
        if high - low >= abs(away):
            return k + 1
    return n


@once
def looked(
    on, slots, links, at_rest, p, dt, x, v, a, u, theta, clock, warm, s, reach, shift, shown, plain, left, first, q,
    near, share, raw, path, error, weight, best,
):  # fmt: skip
    """Put into best (2, S) about where a state that may be caught anywhere begins, and what that leaves.

    Its valleys show while it goes through its way for the first time, and some rows more.
    """
    away, _ = way(reach, slots[q])
    n = min(SPAN * crossed(path, slots[q], away, x.shape[0]), x.shape[0])
    share[q] = best[0, q] = 0.0
    best[1, q] = missed(error[:n], weight, shown, share, q)
    for look in range(LOOKS + 2 * HALVINGS):
        share[q] = aim(look, near[q], best[0, q])
        if abs(share[q]) < MOVED:
            continue
        chord(
            on, slots, links, at_rest, p, dt, x[:n], v[:n], a[:n], u[:n], theta[:n], clock, warm, s, reach, shift,
            shown, plain, left, first, q, share[q], raw, path,
        )  # fmt: skip
        over = missed(error[:n], weight, shown, share, q)
        if over < best[1, q]:
            best[0, q], best[1, q] = share[q], over


@once
def chords(
    on, slots, links, at_rest, p, dt, x, v, a, u, theta, clock, warm, s, reach, shift, hint, shown, plain, left, near,
    share, drawn, first, raw, path, error, weight, best, redrawn,
):  # fmt: skip
    """Draw into `shown` the chord of each state that follows no straight line; whether any was drawn anew.

    share (S,): the shares of the ways that the chords go to; drawn (S,): those that they went to before. Motion: of the
    rows that show; plain (S, n), first (S,): as in `slopes`. best (2, S): share of the run that left least, and what
    that left. A gap has a valley on each side: of what is `CAUGHT` several shares are looked at first where there is no
    hint, and after the last turn a share that has not come to rest is that of the best run.
    """
    anew = False
    for q in range(slots.shape[0]):
        if not crooked(reach, at_rest, slots[q]) or left[q, 0] == 0.0:
            continue
        catches, to = at_rest[slots[q]] == CAUGHT, share[q]
        anywhere = looked_for(at_rest, slots[q], hint)
        last = CHORDS if anywhere or not catches else NEARBY
        if redrawn > last or (redrawn == last and not catches):
            share[q] = stays(to, drawn[q]) if redrawn > last else to
            continue
        fresh = redrawn == 0 and catches
        if fresh and anywhere:
            looked(
                on, slots, links, at_rest, p, dt, x, v, a, u, theta, clock, warm, s, reach, shift, shown, plain, left,
                first, q, near, share, raw, path, error, weight, best,
            )  # fmt: skip
            # its chord was drawn over the first rows only; one to nowhere has no slope
            drawn[q], to = math.nan, best[0, q] if abs(best[0, q]) >= MOVED else MOVED
        elif fresh:
            share[q] = best[0, q] = drawn[q]
            best[1, q] = missed(error, weight, shown, share, q)
        elif redrawn == last and abs(to - drawn[q]) >= MOVED:
            to = best[0, q]
        share[q] = to
        if abs(to) < MOVED or abs(to - drawn[q]) < MOVED:
            continue
        chord(
            on, slots, links, at_rest, p, dt, x, v, a, u, theta, clock, warm, s, reach, shift, shown, plain, left,
            first, q, to, raw, path,
        )  # fmt: skip
        drawn[q], anew = to, True
        if catches:
            over = missed(error, weight, shown, share, q)
            if over < best[1, q] or (fresh and anywhere):
                best[0, q], best[1, q] = to, over
    return anew


@inner
def products(error, weight, shown, unscored, sums):
    """Normal equations of the shares, priors included: sums (S, S + 1); freedom that they take from `unscored` on."""
    many, spent = sums.shape[0], 0.0
    for q in range(many):
        for other in range(many + 1):
            sums[q, other] = 1.0 if other == q else 0.0
        told = 0.0
        for k in range(error.shape[0]):
            pull = weight[k] * shown[q, k]
            for other in range(many):
                sums[q, other] += pull * shown[other, k]
            sums[q, many] += pull * error[k]
            if k >= unscored:
                told += pull * shown[q, k]
        spent += told / sums[q, q]
    return spent


@inner
def shares(sums, near, share):
    """Share (S,) of its way that each state begins at, between `near` and 1."""
    many = share.shape[0]
    for q in range(many):
        share[q] = 0.0
    for _ in range(TURNS):
        for q in range(many):
            rest = sums[q, many] + sums[q, q] * share[q]
            for other in range(many):
                rest -= sums[q, other] * share[other]
            share[q] = min(max(rest / sums[q, q], near[q]), 1.0)


@entry
def begun_rows(
    on, slots, links, at_rest, ps, dt, starts, course, x, v, a, u, theta, n_sub, measured, weight, unscored, hints,
    forces, spent, found,
):  # fmt: skip
    """As `predict_rows`, but each state begins where the measured force (n,) [N] says.

    weight (n,) [1/N2]: how much each sample tells; spent (m,): freedom that this took among the samples of each record
    from `unscored` on; hints (records, n_states): shares of their ways near which states that may be caught anywhere
    begin, NaN where that is to be looked for; found (m, records, n_states): the same as they were found.
    """
    many, n = slots.shape[0], x.shape[0]
    noted = NOTED + 0 * n
    s, reach = np.empty((ROWS, at_rest.shape[0])), np.empty((5, at_rest.shape[0]))
    shown, plain, left = np.empty((many + 1, n)), np.empty((many, n)), np.empty((many, n))
    near, share, drawn, best = np.empty(many), np.empty(many), np.empty(many), np.empty((2, many))
    first, sums = np.empty(many, np.int64), np.empty((many, many + 1))
    raw, error = np.empty(n), np.empty(n)
    records, warm = starts.shape[0] - 1, np.empty(at_rest.shape[0])
    ends, path = np.empty((records, 2, at_rest.shape[0])), np.empty((n, 2 * at_rest.shape[0]))
    for k in range(ps.shape[0]):
        p, force = ps[k], forces[k]
        shift, spent[k] = output_delay(on, p) / dt, 0.0
        for turn in range(records):
            r = int(course[turn, TURN])
            i, j, clock = starts[r], starts[r + 1], course[r, CLOCK]
            cooled(course, r, ends, warm)
            x_r, v_r, a_r = x[i:j], v[i:j], a[i:j]
            u_r, theta_r, f_r = u[i:j], theta[i:j], force[i:j]
            predict(
                on, slots, links, at_rest, p, dt, x_r, v_r, a_r, u_r, theta_r, n_sub, clock, warm, s, f_r, reach, noted,
                0.0, raw, path,
            )  # fmt: skip
            ended(s, r, ends)
            for row in range(j - i):
                shown[many, row] = f_r[row]
            late(f_r, shift, raw[i:j])
            rows = slopes(
                on, slots, links, at_rest, p, dt, x_r, v_r, a_r, u_r, theta_r, clock, warm, s, reach, shift,
                hints[r], n_sub == 1, shown, plain, left, near, drawn, first, raw, path,
            )  # fmt: skip
            for row in range(rows):
                error[row] = measured[i + row] - f_r[row]
            told = 0.0
            for redrawn in range(CHORDS + 1):
                told = products(error[:rows], weight[i:j], shown, unscored, sums)
                shares(sums, near, share)
                if not chords(
                    on, slots, links, at_rest, p, dt, x_r[:rows], v_r[:rows], a_r[:rows], u_r[:rows], theta_r[:rows],
                    clock, warm, s, reach, shift, hints[r], shown, plain, left, near, share, drawn, first,
                    raw[:rows], path, error[:rows], weight[i:j], best, redrawn,
                ):  # fmt: skip
                    break
            spent[k] += told
            for q in range(many):
                if at_rest[slots[q]] == CAUGHT and left[q, 0] != 0.0:
                    found[k, r, slots[q]] = drawn[q]
                for row in range(rows):
                    f_r[row] += share[q] * shown[q, row]
