"""Sampling, dropouts, held samples and clipping of one record."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from er_records.record import HELD, Array, Record, is_core
from numpy.typing import NDArray

from er_model_lab.preflight.finding import Finding, Level, spans_of

JITTERY = 0.1
"""Jitter over the sample time that is worth a word."""
SLOW = 100.0
"""Sampling rate [Hz] below which the force of the field cannot be followed."""
FEW, MANY, MANY_FORCES = 0.001, 0.02, 0.05
"""Shares of clipped samples from which on a finding is a warning, and a failure; of the force a larger one, since its
clipped samples get no weight."""
LOST = 0.001
"""Share of lost samples that is worth a warning."""
OWN_RATE = 0.3
"""Share of repeats from which on a channel has a slower rate of its own."""
STUCK = 0.1
"""Time that a channel may stand still while others move [s]."""
MOVED = 0.2
"""Share of its range by which another channel must move meanwhile."""
ALIVE = 0.01
"""Share of its range by which another channel must move in a run that is called clipped."""
LONE = 10
"""Samples of a single run from which on it is no chance."""
RESTS = 10
"""Values at which a channel rests from which on their distance tells the step of its converter."""
USUAL, UNUSUAL = 0.99, 5.0
"""Share of the runs of a channel that are usual, and how much longer one is that it hung in."""
STUCK_FAIL = 0.2
"""Share of a record in which a stuck channel makes it useless."""

EXEMPT = HELD | {"temperature", "road", "actuator_force"}
"""Channels that may stand still."""


def time_findings(record: Record) -> Iterator[Finding]:
    """Rate, jitter and lost samples, from the times as stored."""
    timing = record.timing
    if timing is None or timing.dt <= 0.0:
        return
    rate = 1.0 / timing.dt
    found = f"{rate:.4g} Hz, jitter {1e3 * timing.jitter:.2g} ms rms"
    if timing.unit:
        found = f"{rate:.4g} Hz, times rounded to {1e3 * timing.unit:g} ms"
    level: Level = "ok"
    if rate < 0.99 * SLOW or timing.jitter > JITTERY * timing.dt:
        level = "warning"
    yield Finding(
        "sampling", level, record.name, "", f"at least {SLOW:g} Hz, jitter below {JITTERY:.0%} of a sample",
        found, "" if level == "ok" else "record faster, stamped by the sensor's own clock", record.source,
    )  # fmt: skip
    share = timing.lost / max(timing.rows + timing.lost, 1)
    level = "warning" if share > LOST else "note" if timing.lost or timing.repeated else "ok"
    words = f"{timing.lost} lost ({share:.2%}), longest step {1e3 * timing.longest:.3g} ms"
    if timing.repeated:
        words += f", {timing.repeated} rows repeat the time before"
    yield Finding(
        "dropouts", level, record.name, "", "no sample lost", words,
        "" if level == "ok" else "record with less load or larger queues (./er doctor)", record.source, timing.holes,
    )  # fmt: skip


def wait_findings(record: Record) -> Iterator[Finding]:
    """Topics of a bag that wait longer between stamp and arrival than the others: another clock, or a slow way."""
    if len(record.waits) < 3:
        return
    usual = float(np.median([wait for wait, _ in record.waits.values()]))
    for topic, (wait, spread) in record.waits.items():
        if abs(wait - usual) > max(record.dt, spread):
            yield Finding(
                "clock", "warning", record.name, topic, "stamps of the same clock as the other topics",
                f"{1e3 * (wait - usual):+.3g} ms more from stamp to arrival than usual, spread {1e3 * spread:.2g} ms",
                "synchronise the clocks of both computers, or stamp where the sample is taken", record.source,
            )  # fmt: skip


@dataclass(frozen=True)
class Runs:
    """Runs of equal samples: first row and length of each that is longer than one."""

    first: NDArray[np.intp]
    length: NDArray[np.intp]


def runs(y: Array) -> Runs:
    """Runs of at least two equal samples."""
    edges = np.concatenate([[0], np.flatnonzero(np.diff(y) != 0.0) + 1, [y.size]])
    length = np.diff(edges)
    long = length > 1
    return Runs(edges[:-1][long], length[long])


def held_findings(record: Record) -> Iterator[Finding]:
    """Channels that repeat their samples: a slower rate of their own, or a sensor that hangs."""
    for name, y in record.channels.items():
        if not is_core(name) or name in EXEMPT or name in record.derived:
            continue
        if np.ptp(y) == 0.0:
            yield Finding(
                "held", "fail" if _needed(name) else "warning", record.name, name, "samples that change",
                f"{y[0]:g} throughout", "check the wiring and the topic", record.source,
            )  # fmt: skip
            continue
        if clipped(y, others(record, name)).sum() > FEW * y.size:
            continue
        found = runs(y)
        yield from _slower(record, name, y, found)
        yield from _stuck(record, name, found)


def _needed(name: str) -> bool:
    """Whether the lab can do nothing without the channel."""
    return name in ("damper_force", "deflection", "deflection_velocity")


def _slower(record: Record, name: str, y: Array, found: Runs) -> Iterator[Finding]:
    """A channel whose values come in groups: its own rate is lower than that of the record."""
    steps = np.abs(np.diff(y))
    moves = steps[steps > 0.0]
    # a coarse converter repeats as well, but then it moves by one or two of its steps
    coarse = float(np.median(moves)) < 3.5 * float(moves.min())
    share = 1.0 - moves.size / steps.size
    if share < OWN_RATE or coarse:
        return
    every = int(np.median(found.length))
    rate = 1.0 / record.dt / every
    yield Finding(
        "held", "warning", record.name, name, f"{1.0 / record.dt:.4g} values a second",
        f"each value {every} times: about {rate:.3g} Hz, late by {1e3 * record.dt * (every - 1) / 2:.2g} ms on average",
        f"record {name} at the rate of the others, or leave its repeats empty", record.source,
    )  # fmt: skip


def _stuck(record: Record, name: str, found: Runs) -> Iterator[Finding]:
    """A channel that stands still while others move.

    A damper that sticks stands still while its force changes: where only that moves, nobody can know.
    """
    still = {c: y for c, y in record.channels.items() if c == name or c != "damper_force"}
    moving, sure = others(replace(record, channels=still), name), True
    if not moving:
        moving, sure = others(record, name), False
    stuck, least = np.zeros(len(record), bool), max(round(STUCK / record.dt), 10)
    long = found.length >= least
    for i, n in zip(found.first[long], found.length[long], strict=True):
        if moving and _moved(moving, int(i), int(n)) > MOVED:
            stuck[i : i + n] = True
    if rows := int(stuck.sum()):
        share, what = rows / len(record), "other channels move" if sure else "the force changes"
        yield Finding(
            "held", "fail" if sure and share > STUCK_FAIL else "warning", record.name, name,
            "samples that follow the motion",
            f"{rows * record.dt:.3g} s ({share:.1%}) stuck while {what}",
            "check the cable and the amplifier; cut these stretches out, unless the damper sticks", record.source,
            spans_of(record.t, stuck),
        )  # fmt: skip


def clipped(y: Array, others: list[Array]) -> NDArray[np.bool_]:
    """Samples (n,) in runs of three or more at the largest or at the smallest value while others move.

    The last step before the run must be a large one: a coarse converter stays at its highest value, too, but
    comes there in its smallest steps. Noise breaks a flat top into long and many short runs, which nothing moves in:
    most of the samples must lie in runs in which others do. One short run alone is chance, or a rest, unless the other
    end of the range, as far from zero, is clipped as well. others: channels (n,) over their ranges.
    """
    steps, top = np.abs(np.diff(y)), np.zeros(y.size, bool)
    moves = steps[steps > 0.0]
    if not moves.size:
        return top
    found = runs(y)
    quantum = max(float(moves.min()), _between_rests(y[found.first]))
    low, high = float(y.min()), float(y.max())
    runs_at = {
        e: (y[found.first] == e) & (found.length >= 3) & (found.first > 0) for e in (low, high)
    }
    many = {e: at.sum() >= 2 or found.length[at].sum() >= LONE for e, at in runs_at.items()}
    mirrored = abs(low + high) <= 2.0 * quantum
    for extreme, at in runs_at.items():
        if not at.any() or not (many[extreme] or (mirrored and any(many.values()))):
            continue
        into = steps[found.first[at] - 1]
        first, length = found.first[at], found.length[at]
        moved = [_moved(others, int(i), int(n)) for i, n in zip(first, length, strict=True)]
        of_samples = float(np.median(np.repeat(moved, length)))
        if float(np.median(into)) > 5.0 * quantum and of_samples > ALIVE:
            for i, n in zip(first, length, strict=True):
                top[i : i + n] = True
    return top


def _between_rests(values: Array) -> float:
    """Least distance of the values of runs (n,), 0 of few: a converter's step, which resampling leaves to these."""
    different = np.unique(values)
    return float(np.diff(different).min()) if different.size >= RESTS else 0.0


def hung(y: Array, others: list[Array], dt: float) -> NDArray[np.bool_]:
    """Samples (n,) of one and the same value for 0.1 s or more while others move: a cable, or a range that ended.

    Runs that are usual in the channel are none: of a coarse converter, or of a slower rate of its own. dt: [s].
    """
    still, found = np.zeros(y.size, bool), runs(y)
    if not others or not found.length.size:
        return still
    alone = y.size - int(found.length.sum())
    usual = float(np.quantile(np.concatenate([np.ones(alone), found.length]), USUAL))
    least = max(STUCK / dt, LONE, UNUSUAL * usual)
    for i, n in zip(found.first, found.length, strict=True):
        still[i : i + n] = n >= least and _moved(others, int(i), int(n)) > MOVED
    return still


def _moved(others: list[Array], i: int, n: int) -> float:
    """Largest share of its range that another channel moves over in a run."""
    return max((float(np.ptp(y[i : i + n])) for y in others), default=1.0)


def others(record: Record, name: str) -> list[Array]:
    """The other channels of motion and force over their ranges."""
    return [
        y / max(float(np.ptp(y)), 1e-300)
        for other, y in record.channels.items()
        if other != name and is_core(other) and other not in EXEMPT
    ]


def clipping_findings(record: Record) -> Iterator[Finding]:
    """Channels that ran into the end of their range."""
    for name, y in record.channels.items():
        if not is_core(name) or name in EXEMPT or name in record.derived:
            continue
        flat = clipped(y, others(record, name))
        n = int(flat.sum())
        share = n / len(record)
        if share < FEW / 10.0:
            continue
        most = MANY_FORCES if name == "damper_force" else MANY
        level: Level = "fail" if share > most else "warning" if share > FEW else "note"
        yield Finding(
            "clipping", level, record.name, name, "no flat tops",
            f"{n} samples ({share:.2%}) at the end of the range, {float(np.abs(y).max()):.4g}",
            "use a larger range of the amplifier, or drive less", record.source, spans_of(record.t, flat),
        )  # fmt: skip
