"""What is fitted, what is held out, and what is neither."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from er_models.errors import InputError
from er_models.model import Array
from er_models.prediction import Motion
from numpy.typing import NDArray

WARM_UP = 0.3
"""Time at the start of each record in which unknown initial states show most [s]; not scored."""
FOLDS = 12
"""Blocks for cross-validation."""
GUARD = 0.25
"""Time between what is fitted and what is held out [s]."""
STRETCHES, SHORTEST = 10, 0.5
"""How many stretches a record is cut into, of which a third is held out; fewer where they were shorter [s]."""
ALIKE = 0.8
"""How much the stretches held out move at least, as a share of the whole."""
LOST = 0.1
"""Share of a reach that may be lost by holding out a record that reaches furthest in something."""
TO_FIT, TO_HOLD_OUT = 100, 30
"""Samples without which nothing can be fitted or scored."""
JUMP, SELDOM = 0.05, 0.05
"""Share of its range by which the duty jumps, and the share of samples below which jumps are left out."""


def split(
    motion: Motion, scored: int = 0, *, evenly: bool = False
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Fold of each training sample (-1: not used) and mask of the held-out samples.

    The last `scored` records are held out whole, if any are. Otherwise, of three records or more, about a
    quarter is held out whole (`spared`); of fewer, a third of some ten stretches of each, of short records of
    fewer, but three (`spared_stretches`; every third where `evenly`, for a motion that is not measured), with a
    guard on both sides.
    """
    starts, dt = motion.starts, motion.dt
    n, records = int(starts[-1]), len(starts) - 1
    fold = np.full(n, -1, np.int64)
    held = np.zeros(n, bool)
    guard = round(GUARD / dt)
    unsure = switching(motion)
    chosen = set(range(records - scored, records)) if scored else spared(motion)
    for r in range(records):
        i, j = int(starts[r]) + round(WARM_UP / dt), int(starts[r + 1])
        if j - i < 8:
            continue
        if chosen:
            if r in chosen:
                held[i:j] = True
            else:
                fold[i:j] = 0
            continue
        stretches = min(max(int((j - i) * dt / SHORTEST), 3), STRETCHES)
        edges = list(itertools.pairwise(np.linspace(i, j, stretches + 1).astype(int).tolist()))
        kept_back = every_third(stretches) if evenly else spared_stretches(motion, edges)
        for b, (lo, hi) in enumerate(edges):
            if b in kept_back:
                held[min(lo + guard, hi) : hi] = True
            else:
                fold[lo : max(hi - guard, lo)] = 0
    fold[unsure], held[unsure] = -1, False
    order = np.flatnonzero(fold >= 0)
    if order.size < TO_FIT or held.sum() < TO_HOLD_OUT:
        expected = (
            f"at least {TO_FIT} samples to fit and {TO_HOLD_OUT} to hold out, {GUARD:g} s apart"
        )
        found = f"{order.size} and {int(held.sum())} in the {n * dt:.3g} s recorded"
        raise InputError("data", "length", expected, found)
    fold[order] = np.arange(order.size) * FOLDS // order.size
    return fold, held


def telling(
    motion: Motion, train: NDArray[np.bool_], held_out: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Samples (n,) that tell where the states of their record begin, of masks (n,) of those learnt from and held out.

    The first ones, which nothing is judged by, and those that are learnt from; in a record that only scores all do.
    """
    told = train.copy()
    for i, j in itertools.pairwise(motion.starts.tolist()):
        if not train[i:j].any():
            told[i:j] = held_out[i:j]
        told[i : min(i + round(WARM_UP / motion.dt), j)] = True
    return told


def switching(motion: Motion) -> NDArray[np.bool_]:
    """Samples (n,) at whose very instant the duty jumps: whether the force is that before or after it, nobody knows.

    What follows the duty at once makes the two differ, and a lag of no length would explain it. Where the duty
    changes all the time no sample is another's better, and none is marked.
    """
    u = motion.u
    jumps = np.abs(np.diff(u, prepend=u[0])) > JUMP * float(np.ptp(u))
    jumps[motion.starts[:-1]] = False
    return jumps if np.mean(jumps) < SELDOM else np.zeros(u.size, bool)


def reaches(motion: Motion, parts: Sequence[tuple[int, int]]) -> Array:
    """How far each part (from, to) goes in what the damper feels (p, 8).

    Deflection, velocity, and velocity with the field, both ways; duty, both ways.
    """
    felt = (motion.x, motion.v, motion.v * motion.u)
    return np.array(
        [
            [float(np.quantile(s * y[i:j], 0.999)) for y in felt for s in (-1.0, 1.0)]
            + [float(motion.u[i:j].max()), float(-motion.u[i:j].min())]
            for i, j in parts
        ]
    )


def every_third(stretches: int) -> tuple[int, ...]:
    """Stretches that are held out where nothing speaks against it."""
    return tuple(range(2, stretches, 3))


def spared_stretches(motion: Motion, parts: Sequence[tuple[int, int]]) -> tuple[int, ...]:
    """Which third of some stretches (from, to) to hold out.

    What only they exercise could never be learnt, as in `spared` (a cut-off may act in the last hundredths of
    the reach alone), and a standstill tells nothing: without them the least reach is lost, and they move by
    `ALIKE` of the whole. Of the choices that do, the one that is spread most evenly over the record.
    """
    reach, even = reaches(motion, parts), every_third(len(parts))
    power = np.array([float(np.mean(motion.v[i:j] ** 2)) for i, j in parts])
    whole = np.maximum(np.abs(reach).max(axis=0), 1e-300)

    def price(chosen: tuple[int, ...]) -> tuple[float, int]:
        rest = np.delete(reach, chosen, axis=0).max(axis=0)
        lost = float(np.max((reach.max(axis=0) - rest) / whole))
        moves = float(np.sqrt(power[list(chosen)].mean() / max(float(power.mean()), 1e-300)))
        wrong = lost + max(ALIKE - moves, 0.0)
        return round(wrong, 2), sum(abs(b - e) for b, e in zip(chosen, even, strict=True))

    return min(itertools.combinations(range(len(parts)), len(even)), key=price)


def spared(motion: Motion) -> set[int]:
    """Records to hold out: about a quarter, none of which reaches furthest in anything the damper feels.

    What only the held-out records exercise could never be learnt: an end stop touched once, a cut-off at the
    fastest stroke. Only inputs decide, never the force. Empty for fewer than three records, and where each of them
    reaches clearly further than the others in something.
    """
    pairs = list(itertools.pairwise(motion.starts))
    if len(pairs) < 3:
        return set()
    length = [[float(j - i)] for i, j in pairs]
    reach = np.hstack([reaches(motion, pairs), length])
    size = np.maximum(np.abs(reach).max(axis=0), 1e-300)
    widest = np.max(reach / size - (reach / size).max(axis=0) + 1.0, axis=1)
    order = np.argsort(widest, kind="stable")
    wanted = max(1, len(pairs) // 4)
    inner = [int(r) for r in order if widest[r] < 1.0 - 1e-9]
    if len(inner) < wanted:
        least = np.argsort((reach / size).sum(axis=1), kind="stable")[:wanted]
        lost = (reach.max(axis=0) - np.delete(reach, least, axis=0).max(axis=0)) / size
        return {int(r) for r in least} if lost.max() <= LOST else set()
    places = np.linspace(0, len(inner) - 1, wanted).round().astype(int)
    return {inner[k] for k in places}
