"""The search for the states that feed back: they are read in a look at the damper before it brings them forward.

Each is found by a bracketed secant in its own coordinate. Where the damper is in series with something, the rest of
its force (all but stiffness and damping) is one of them. Friction makes that search steep: while the damper sticks,
all it can be lies within a hundredth of a newton of a guess that errs by twenty. So it begins where the damper would
move as fast as in the step before, and is found anew for each trial of the other states.

The text below the marker is compiled together with the equations of a catalogue (`kernel.compose`).
"""

from __future__ import annotations

import math

from er_models.kernel.fast import inner
from er_models.kernel.rows import (
    HIGH,
    LARGEST,
    LAST,
    LOW,
    MISS,
    SLOPE,
    SPEED,
    SPEED_LAST,
    SPEED_THEN,
    TRY,
    W0,
    YIELDING,
    W,
)

# --- below this line: compiled with the composed equations ---
PATIENCE = 6
"""Looks after which every other trial halves the bracket."""
FARTHEST = 1e50
"""Beyond this a state is no number."""
CLOSE = 1e-10
"""Relative error of a state that feeds back."""
STEEP = -10.0
"""Slope from which the damper sticks."""


@inner
def begin(links, s):
    """Start the search where the states are."""
    for i in range(links.shape[0]):
        renewed(s, links[i])
    s[SPEED_THEN, s.shape[1] - 1] = s[SPEED, s.shape[1] - 1]


@inner
def renewed(s, j):
    """Begin the search for state j anew, from where it is."""
    s[TRY, j] = s[W, j]
    s[MISS, j] = 0.0
    s[LOW, j] = -math.inf
    s[HIGH, j] = math.inf


@inner
def refined(links, s, k, force):
    """Whether every state that feeds back agrees with what follows from it; if not, the next trial is set.

    The rest of the force, the last state, is a difference: it is known as well as the largest force [N], no better.
    Trials that lead beyond measure are no side of a bracket: the search begins anew, halfway back to where they were.
    """
    rest, many = s.shape[1] - 1, links.shape[0]
    off, halve = False, k >= PATIENCE and k % 2 == 0
    for i in range(many):
        j = links[i]
        if not abs(s[W, j]) < FARTHEST:
            again(links, s)
            return False
        if j != rest and not abs(s[W, j] - s[TRY, j]) <= CLOSE * (abs(s[W, j]) + abs(s[W0, j])):
            off = True
    if links[many - 1] == rest:
        size = s[LARGEST, rest] + abs(s[W, rest]) + abs(force)
        if not abs(s[W, rest] - s[TRY, rest]) <= CLOSE * size:
            for i in range(many - 1):
                s[W, links[i]] = s[TRY, links[i]]
            next_rest(s, rest, k, halve)
            return False
        s[LARGEST, rest] = max(s[LARGEST, rest], abs(force))
    if off:
        for i in range(many):
            if links[i] == rest:
                renewed(s, rest)
            else:
                next_trial(s, links[i], halve)
    return not off


@inner
def again(links, s):
    """Begin the search anew, nearer to where the states were before the step."""
    for i in range(links.shape[0]):
        j = links[i]
        s[W, j] = 0.5 * (s[W0, j] + s[TRY, j])
        s[SLOPE, j] = 0.0
    begin(links, s)


@inner
def next_rest(s, j, k, halve):
    """Next trial of the rest of the force; the first one, where the damper sticks, keeps its velocity."""
    at, speed = s[TRY, j], s[SPEED, j]
    if k > 0 and speed != s[SPEED_LAST, j] and at != s[LAST, j]:
        s[YIELDING, j] = (s[LAST, j] - at) / (speed - s[SPEED_LAST, j])
    s[SPEED_LAST, j] = speed
    if k > 0 or s[SLOPE, j] > STEEP or s[YIELDING, j] == 0.0:
        next_trial(s, j, halve)
        return
    bracket(s, j)
    trial = at + (speed - s[SPEED_THEN, j]) * s[YIELDING, j]
    s[LAST, j] = at
    s[TRY, j] = trial if s[LOW, j] <= trial <= s[HIGH, j] else s[W, j]
    s[W, j] = s[TRY, j]


@inner
def bracket(s, j):
    """Keep the trial of state j as one side of what it may be; how far it is from what follows from it."""
    at, miss = s[TRY, j], s[W, j] - s[TRY, j]
    if miss > 0.0:
        s[LOW, j] = at
    elif miss < 0.0:
        s[HIGH, j] = at
    return miss


@inner
def next_trial(s, j, halve):
    """Secant towards the trial that follows from itself, kept between those seen on both sides of it.

    halve: take the middle instead, for where the secant creeps along a saturation.
    """
    at, miss = s[TRY, j], bracket(s, j)
    if s[MISS, j] != 0.0 and at != s[LAST, j]:
        s[SLOPE, j] = min((miss - s[MISS, j]) / (at - s[LAST, j]), -0.02)
    if s[SLOPE, j] == 0.0:
        s[SLOPE, j] = -1.0
    s[LAST, j], s[MISS, j] = at, miss
    trial = at - miss / s[SLOPE, j]
    both = s[LOW, j] > -math.inf and s[HIGH, j] < math.inf
    if (halve and both) or not s[LOW, j] <= trial <= s[HIGH, j]:
        trial = 0.5 * (s[LOW, j] + s[HIGH, j]) if both else at + miss
    s[TRY, j] = trial
    s[W, j] = trial
