"""The damper force along a measured motion, one sample at a time: `predict` for who cannot wait for the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from er_models.errors import InputError
from er_models.kernel.load import kernel
from er_models.kernel.rows import ROWS
from er_models.model import Array, Compiled, Model
from er_models.prediction import substeps

LONGEST_DELAY = 0.08
"""Duties and forces are remembered this long, for dead time and delays [s]."""


class Sample(NamedTuple):
    """Deflection x [m], velocity v [m/s], acceleration a [m/s2], duty u from then on [1], temperature theta [K]."""

    x: float
    v: float
    a: float
    u: float
    theta: float = 0.0


class Following(NamedTuple):
    """Where m dampers are: forces (m,) [N] as their sensor shows them, time since the start [s], what is remembered.

    sample (5,): the last one; states (m, ROWS, n_states); duties (depth,), forces_before (m, depth): newest last.
    """

    forces: Array
    t: float
    sample: Array
    states: Array
    duties: Array
    forces_before: Array


@dataclass(frozen=True)
class Follower:
    """A damper prepared for following a motion.

    dt: between two samples [s]; apart (m,): velocities by which m dampers move faster than measured [m/s]: what an
    error of the velocity would change; depth: samples remembered.
    """

    model: Model
    dt: float
    apart: Array
    c: Compiled
    n_sub: int
    depth: int


def follower(model: Model, dt: float, apart: Sequence[float] = (0.0,)) -> Follower:
    """A damper, or that of a car, ready for `begin` and `follow`; arguments as in `Follower`.

    Raises:
        InputError: A dt that is not above zero.
    """
    if not dt > 0.0:
        raise InputError("follower", "dt", "a time above 0 s", f"{dt:g} s")
    depth = int(np.ceil(LONGEST_DELAY / dt)) + 4
    return Follower(model, dt, np.array(apart, float), model.compiled(), substeps(dt), depth)


def begin(f: Follower, sample: Sample) -> Following:
    """In equilibrium with the first sample but for states that begin at rest, as `predict` begins a record."""
    c, many = f.c, f.apart.size
    states, forces = np.empty((many, ROWS, c.at_rest.shape[0])), np.empty(many)
    x, v, a, u, theta = map(float, sample)
    settle = kernel(f.model.catalogue).settle_point
    for i, more in enumerate(f.apart.tolist()):
        forces[i] = settle(
            c.on, c.slots, c.links, c.at_rest, c.p, states[i], x, v + more, a, u, theta
        )
    before = np.repeat(forces[:, None], f.depth, axis=1)
    return Following(forces, 0.0, np.array(sample, float), states, np.full(f.depth, u), before)


def follow(f: Follower, state: Following, sample: Sample) -> Following:
    """The dampers dt later, at the next sample: a pure step.

    It gives what `predict` gives of the whole record, but for a force that is shown less than two samples late: what
    follows is not foreseen.

    Source: as `predict`.
    """
    c, (_, t, last, states, duties, before) = f.c, state
    now, forces = np.array(sample, float), np.empty(f.apart.size)
    states, before, later = states.copy(), before.copy(), np.empty(f.depth)
    later[:-1], later[-1] = duties[1:], sample.u
    kernel(f.model.catalogue).advance(
        c.on, c.slots, c.links, c.p, states, f.dt, t, last, now, f.apart, later, f.n_sub, before, forces
    )  # fmt: skip
    return Following(forces, t + f.dt, now, states, later, before)
