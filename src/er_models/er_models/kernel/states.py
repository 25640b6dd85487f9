r"""States of the damper over one step of imposed motion.

Every state relaxes, ``w' = drive - rate w`` with ``rate >= 0``. Where the motion is imposed it is
integrated exactly for a drive that is linear between the ends of the step (first-order hold;
Hochbruck and Ostermann 2010, exponential trapezoidal rule): decays are exact, a stiff state
follows its equilibrium, and one look at the equations per step is enough. Inside the quarter car
the same step is one implicit stage (`kernel.vehicle`).

The composed `damper` updates each state where the equations first need it, so that a chain of
states is solved in one pass. States that feed back (`Compiled.links`) are found by the search of
`kernel.search`.

The text below the marker is compiled together with the equations of a catalogue
(`kernel.compose`).
"""

from __future__ import annotations

import math

from er_models.effect import INSTANT
from er_models.kernel.elementary import exp
from er_models.kernel.fast import inline, inner, linked, once
from er_models.kernel.layout import HEAT, ZERO
from er_models.kernel.rows import DECAY, G0, ONE, R0, ROWS, TWO, W0, G, R, W, Z
from er_models.kernel.search import begin, refined


def damper(on, p, s, h, how, x, v, a, u, t, theta):  # type: ignore[no-untyped-def]
    """Composed from the catalogue: true force, measured force and duty at the fluid; updates s."""
    raise NotImplementedError("replaced by kernel.compose")


# --- below this line: compiled with the composed equations ---
HOLD, STAGE, SETTLE = 0.0, 1.0, 2.0
"""How a step is taken: first-order hold, one implicit stage, or all the way to equilibrium."""
AT_ONCE = 0.999 * INSTANT
"""Rate [1/s] from which a state has no inertia: a little below `INSTANT`, which 1 / `SHORTEST` misses by rounding."""
SERIES = 0.02
"""Below this the weights of the first-order hold come from their series: the formulas would cancel."""
STIFF = 0.5
"""Rate times step from which a state mostly forgets where it was."""
PASSES = 40
"""Looks at the damper after which the search gives up: a jump in an equation has no better answer."""
SWEEPS = 9
"""How often the damper is swept to find where its states begin."""
RESTING = -1.0
"""Marks a state that begins at zero, not in equilibrium."""


@inline
def weights(z):
    """Decay exp(-z) over a step, and the integrals over it of a constant and of a ramp, per length."""
    if z < SERIES:
        one = 1.0 - z * (0.5 - z * (1.0 / 6.0 - z / 24.0))
        two = 0.5 - z * (1.0 / 6.0 - z * (1.0 / 24.0 - z / 120.0))
        return 1.0 - z * one, one, two
    decay = exp(-z)
    one = (1.0 - decay) / z
    return decay, one, (1.0 - one) / z


@inline
def pace(rate0, rate, h):
    """Product of rate and step that the weights are taken at, and how many ends of the step are stiff."""
    stiff = (h * rate0 > STIFF) + (h * rate > STIFF)
    return (h * rate if stiff == 1 else 0.5 * h * (rate0 + rate)), stiff


@inline
def weighted(w0, rate0, drive0, rate, drive, h, z, stiff, decay, one, two):
    """State after h [s]: exact for a constant rate and a drive linear in time.

    A stiff rate that changes sets the pace towards an equilibrium that is linear in time. Where an equation
    becomes stiff or ceases to be (a contact closes or opens), only its end counts.
    """
    if stiff == 0:
        return decay * w0 + h * ((one - two) * drive0 + two * drive)
    if stiff == 1:
        return decay * w0 + h * one * drive
    return decay * w0 + z * ((one - two) * (drive0 / rate0) + two * (drive / rate))


@inline
def held(w0, rate0, drive0, rate, drive, h):
    """State after h [s], as `weighted`."""
    z, stiff = pace(rate0, rate, h)
    decay, one, two = weights(z)
    return weighted(w0, rate0, drive0, rate, drive, h, z, stiff, decay, one, two)


@inline
def held_again(s, j, h):
    """As `held` for state j, with the weights of the step before where they are the same."""
    rate0, rate = s[R0, j], s[R, j]
    z, stiff = pace(rate0, rate, h)
    if z != s[Z, j]:
        s[Z, j] = z
        s[DECAY, j], s[ONE, j], s[TWO, j] = weights(z)
    return weighted(
        s[W0, j], rate0, s[G0, j], rate, s[G, j], h, z, stiff, s[DECAY, j], s[ONE, j], s[TWO, j]
    )


@inline
def follow(s, j, h, how):
    """State j at the end of a step of length h, by one of the three ways."""
    rate, drive = s[R, j], s[G, j]
    if how == SETTLE:
        return drive / rate if rate > 0.0 and s[R0, j] != RESTING else 0.0
    if rate >= AT_ONCE:
        return drive / rate
    if h == 0.0:
        return s[W0, j]
    if how == HOLD:
        return held_again(s, j, h)
    return (s[W0, j] + h * drive) / (1.0 + h * rate)


@inline
def foreseen(s, j, h, how, goal):
    """Where a lag j towards a goal will be at the end of a step, at the pace of its beginning: first order in the step.

    A pace that hangs on where the lag is takes it from there, which leaves out no more than the step itself does.
    """
    if how == SETTLE:
        return goal
    z = h * s[R0, j]
    return (s[W0, j] + z * goal) / (1.0 + z)


@inner
def pressed(s, j, h, how, bound, give):
    """State j at the end of a step where what lies beyond +-bound springs back at a rate `give`.

    That part decays faster, from where it was, or from when the state came to its bound within the step.
    """
    w, w0 = s[W, j], s[W0, j]
    begun = abs(w0) > bound
    if abs(w) <= bound and not begun:
        return w
    edge = math.copysign(bound, w0 if begun else w)
    rate, drive = s[R, j] + give, s[G, j] - s[R, j] * edge
    if how == SETTLE:
        beyond = drive / rate
    elif how == STAGE:
        beyond = (w0 - edge + h * drive) / (1.0 + h * rate)
    elif begun:
        beyond = held(w0 - edge, s[R0, j], s[G0, j] - s[R0, j] * edge, rate, drive, h)
    else:
        beyond = held(0.0, rate, drive, rate, drive, h * (w - edge) / (w - w0))
    if beyond * (w0 if begun else w) <= 0.0:
        if begun and how == HOLD:
            return left(s, j, h, bound, give, edge)
        return min(max(w, -bound), bound)
    s[R, j] = rate
    s[G, j] += give * edge
    return edge + beyond


@inner
def left(s, j, h, bound, give, edge):
    """State j at the end of a step in which it comes back from beyond +-bound, which may lead beyond the other side."""
    off, r, g = s[W0, j] - edge, s[R0, j], s[G, j] - s[R, j] * edge
    mean = 0.5 * (s[G0, j] - r * edge + g)
    g = mean if mean * off < 0.0 else g
    h -= min(math.log1p(-off * r / g) / r, h) if off * r * g < 0.0 else 0.0
    w = held(edge, s[R, j], s[G, j], s[R, j], s[G, j], h)
    if abs(w) <= bound:
        return w
    if w * edge > 0.0:
        return edge
    h *= (w + edge) / (w - edge) if bound > 0.0 else 1.0
    s[G, j] += s[R, j] * edge
    s[R, j] += give
    beyond = held(0.0, s[R, j], s[G, j], s[R, j], s[G, j], h)
    s[G, j] -= s[R, j] * edge
    return beyond - edge


@once
def solve(on, links, p, s, h, how, x, v, a, u, t, theta):
    """Forces and duty at the end of a step of length h, with all states; h = 0 only evaluates."""
    if links.shape[0]:
        begin(links, s)
    forces = (0.0, 0.0, 0.0)
    for k in range(PASSES):
        forces = damper(on, p, s, h, how, x, v, a, u, t, theta)
        if not links.shape[0] or refined(links, s, k, forces[0]):
            break
    return forces


@linked
def visit(on, links, p, s, h, how, x, v, a, u, t, theta):
    """As `solve`, called instead of written into its place: where compiling once more would cost more than the call."""
    return solve(on, links, p, s, h, how, x, v, a, u, t, theta)


@inline
def keep(slots, s):
    """What was the right end of a step becomes the left end of the next."""
    for i in range(slots.shape[0]):
        j = slots[i]
        s[W0, j] = s[W, j]
        s[R0, j] = s[R, j]
        s[G0, j] = s[G, j]


@once
def settle(on, slots, links, at_rest, p, s, x, v, a, u, theta):
    """Start every state in equilibrium with the first sample, except those that start at rest; measured force."""
    for j in range(s.shape[1]):
        for i in range(ROWS):
            s[i, j] = 0.0
        s[R0, j] = RESTING if at_rest[j] == ZERO or at_rest[j] == HEAT else 0.0
        s[Z, j] = math.nan
    f_m = 0.0
    for _ in range(SWEEPS):
        _, f_m, _ = visit(on, links, p, s, 0.0, SETTLE, x, v, a, u, 0.0, theta)
    keep(slots, s)
    return f_m
