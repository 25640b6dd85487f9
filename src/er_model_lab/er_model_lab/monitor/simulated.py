"""What the sequential test does on errors drawn at random: false alarms, and how long a change takes.

An error is coloured noise whose power follows the motion, in the parts of `sequential`; each run draws its own motion
and learns from its own first blocks. All runs go on at once.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from er_models.model import Array
from scipy.signal import lfilter

from er_model_lab.monitor.sequential import HOUR, Known, Rules, learnt

RATE = 200.0
"""Samples per second of the error [Hz]."""
FORCE = 30.0
"""Mean square of the force [N2], and by how much the logarithms of force and doubt wander from block to block."""
WANDERS, MEMORY = (0.8, 0.5), 0.9
AT_ONCE = 400
"""Blocks that are drawn at once."""


@dataclass(frozen=True)
class Drive:
    """What the error is like.

    colour: how much of a sample is that before; parts (3,): of the power, by `sequential`; gusts: scatter of the
    logarithm of the power of a block that no part explains.
    """

    colour: float = 0.0
    parts: tuple[float, float, float] = (0.02, 0.0, 0.0)
    gusts: float = 0.0


def _blocks(
    rules: Rules, drive: Drive, runs: int, rng: np.random.Generator
) -> Iterator[tuple[Array, Array]]:
    """Power (n, runs) and motion (n, runs, 3) of `AT_ONCE` blocks, for ever."""
    size = round(rules.block * RATE)
    past, lull = np.zeros((1, runs)), np.zeros((1, runs, 2))
    own, more = math.sqrt(1.0 - drive.colour**2), math.sqrt(1.0 - MEMORY**2)
    while True:
        noise = rng.standard_normal((AT_ONCE * size, runs), dtype=np.float32)
        e, past = lfilter([own], [1.0, -drive.colour], noise, axis=0, zi=past)
        y, lull = lfilter(
            [more], [1.0, -MEMORY], rng.standard_normal((AT_ONCE, runs, 2)), axis=0, zi=lull
        )
        doubt, force = np.moveaxis(np.exp(y * WANDERS), -1, 0)
        motion = np.stack([np.ones_like(doubt), doubt, FORCE * force], axis=-1)
        gust = np.exp(drive.gusts * rng.standard_normal((AT_ONCE, runs)))
        shape = (e.reshape(AT_ONCE, size, runs) ** 2).mean(axis=1)
        yield shape * gust * (motion @ np.array(drive.parts)), motion


def _learnt(rules: Rules, blocks: Iterator[tuple[Array, Array]]) -> Known:
    next(blocks)  # until the noise has its colour
    each = [next(blocks) for _ in range(math.ceil(rules.blocks / AT_ONCE))]
    power, motion = (np.concatenate(part)[: rules.blocks] for part in zip(*each, strict=True))
    return learnt(rules, power, motion)


def alarms(rules: Rules, drive: Drive, hours: float, runs: int, seed: int) -> int:
    """False alarms in so many hours of motion, shared by so many runs."""
    blocks = _blocks(rules, drive, runs, np.random.default_rng(seed))
    known, total, found = _learnt(rules, blocks), np.zeros(runs), 0
    for _ in range(math.ceil(hours * HOUR / rules.block / runs / AT_ONCE)):
        for power, motion in zip(*next(blocks), strict=True):
            total = known.added(total, power, motion)
            over = total > known.limit
            found += int(over.sum())
            total = np.where(over, 0.0, total)
    return found


def delays(
    rules: Rules, drive: Drive, growth: float, runs: int, seed: int, longest: float = 100.0
) -> Array:
    """Time (runs,) until an alarm, of an error that is suddenly `growth` times as large [s]; inf: none by `longest`."""
    blocks = _blocks(rules, drive, runs, np.random.default_rng(seed))
    known, total, found = _learnt(rules, blocks), np.zeros(runs), np.full(runs, math.inf)
    for power, motion in zip(*next(blocks), strict=True):  # the sum is somewhere when it happens
        total = np.minimum(known.added(total, power, motion), known.limit)
    t = 0.0
    while t < longest:
        for power, motion in zip(*next(blocks), strict=True):
            total, t = known.added(total, growth**2 * power, motion), t + rules.block
            found = np.where((total > known.limit) & np.isinf(found), t, found)
    return np.where(found > longest, math.inf, found)
