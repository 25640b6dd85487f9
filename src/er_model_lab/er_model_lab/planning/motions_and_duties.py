"""What a rig can be asked to do: kinds of motion and of duty, sized by its limits alone.

The frequency at which a sine uses up stroke and velocity together, f* = velocity / (2 pi stroke),
is the middle of all motions: slower ones use the stroke, faster ones the velocity.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from er_model_lab.planning.limits import Limits
from er_model_lab.planning.segment import Segment, Spec

SPEEDS = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0)
"""Frequencies of sines over f*."""
SMALL = 0.25
"""Level of the gentle variants: pre-sliding and creep show where little moves."""
RESOLVED = 12.0
"""Samples a period must have at least."""
SHORTEST = 4.0
"""Length of a piece [s]; slower sines get one period."""


def middle(limits: Limits) -> float:
    """Frequency f* [Hz] at which a sine uses up stroke and velocity together."""
    return limits.velocity / (2.0 * np.pi * limits.stroke)


def motions(limits: Limits) -> Iterator[Segment]:
    """Motions of every kind, without field; their size is found later."""
    f, tones = middle(limits), _several(limits)
    top = 1.0 / (RESOLVED * limits.dt)
    for speed in SPEEDS:
        for level in (1.0, SMALL):
            yield _wave("sine", min(f * speed, top), limits, level)
    for speed in (0.25, 1.0):
        yield _wave("triangle", min(f * speed, top), limits)
    seconds = neat(max(SHORTEST, 2.0 / f))
    for level in (1.0, SMALL):
        for road in (_sweep(limits, seconds), _sines(limits)):
            yield Segment(road, _OFF, seconds, level, tones=tones)
    yield Segment(_ROUGH, _OFF, seconds, tones=tones)
    yield Segment({"kind": "flat"}, _OFF, SHORTEST)


def _sweep(limits: Limits, seconds: float) -> Spec:
    """A sine from slow to fast."""
    ends = {"f0": neat(0.25 * middle(limits)), "f1": _several(limits)[-1]}
    return {"kind": "chirp", "amplitude": limits.stroke, **ends, "sweep": seconds}


def _sines(limits: Limits) -> Spec:
    """Several sines of equal velocity at once."""
    tones = _several(limits)
    amplitudes = [neat(limits.stroke * tones[0] / f) for f in tones]
    return {"kind": "multisine", "frequencies": list(tones), "amplitudes": amplitudes}


def duties(limits: Limits, motion: Segment) -> Iterator[Spec]:
    """Duty programs: held, in steps slow and fast, and waves in step with the motion."""
    d, f = limits.duty, middle(limits)
    quickest = 1.0 / (RESOLVED * limits.dt)
    yield {"kind": "constant", "level": 0.0}
    yield {"kind": "constant", "level": d}
    yield {
        "kind": "stairs",
        "levels": [0.0, neat(d / 3.0), d, neat(2.0 * d / 3.0)],
        "hold": neat(0.25 / f),
    }
    yield {
        "kind": "steps",
        "low": 0.0,
        "high": d,
        "hold_min": neat(0.1 / f),
        "hold_max": neat(1.0 / f),
    }
    for speed in (0.61, 2.43, 6.1):
        yield square(0.0, d, min(speed * f, quickest))
    if motion.road["kind"] in ("sine", "triangle"):
        own = float(motion.road["frequency"])
        for times in (1.0, 2.0):
            yield square(0.0, d, min(times * own, quickest))
        yield {
            "kind": "sine", "mean": d / 2.0, "amplitude": d / 2.0, "frequency": neat(min(2.0 * own, quickest)),
        }  # fmt: skip


def square(low: float, high: float, frequency: float) -> Spec:
    """A square wave of the duty; frequency [Hz]."""
    return {"kind": "square", "low": low, "high": high, "frequency": neat(frequency)}


def everyday(limits: Limits) -> Segment:
    """The program by which a damper is identified: a random road, random steps of the duty."""
    duty = {"kind": "steps", "low": 0.0, "high": limits.duty, "hold_min": 0.3, "hold_max": 2.0}
    return Segment(_ROUGH, duty, limits.duration, tones=_several(limits))


def rich(limits: Limits) -> tuple[Segment, ...]:
    """Pieces that together show nearly everything: random, large and slow, fast; duty in steps of every pace."""
    f, d = middle(limits), limits.duty
    slow, fast = _wave("sine", 0.25 * f, limits), _wave("sine", 4.0 * f, limits)
    return (
        replace(everyday(limits), seconds=2.0 * SHORTEST),
        slow,
        replace(_wave("sine", f, limits), duty=square(0.0, d, 2.43 * f)),
        replace(fast, duty=square(0.0, d, 0.61 * f)),
    )


def variants(segment: Segment, limits: Limits) -> Iterator[Segment]:
    """Neighbours of a segment: faster and slower, gentler and stronger, other pace of the duty."""
    top = 1.0 / (RESOLVED * limits.dt)
    for ratio in (0.8, 1.25):
        if "frequency" in segment.road:
            f = min(segment.road["frequency"] * ratio, top)
            wave = _wave(str(segment.road["kind"]), f, limits, segment.level)
            yield replace(wave, duty=segment.duty)
        if "frequency" in segment.duty:
            f = min(segment.duty["frequency"] * ratio, top)
            yield replace(segment, duty={**segment.duty, "frequency": neat(f)})
    for level in (0.5 * segment.level, min(2.0 * segment.level, 1.0)):
        if segment.moves and SMALL / 2.0 <= level != segment.level:
            yield replace(segment, level=level)
    if segment.duty["kind"] == "square" and segment.duty["low"] == 0.0:
        yield replace(segment, duty={**segment.duty, "low": neat(limits.duty / 3.0)})


def longer(segment: Segment, times: float) -> Segment:
    """The same piece going on for longer, for what needs time to show."""
    return replace(segment, seconds=segment.seconds * times)


_ROUGH: Spec = {"kind": "iso8608", "road_class": "C", "speed": 5.556}
"""ISO 8608 class C at 20 km/h; its height is scaled."""


def _several(limits: Limits) -> tuple[float, ...]:
    """Frequencies of a broad motion [Hz]."""
    f = middle(limits)
    high = min(4.0 * f, 1.0 / (RESOLVED * limits.dt))
    return tuple(neat(x) for x in np.geomspace(0.4 * f, high, 6))


def _wave(kind: str, frequency: float, limits: Limits, level: float = 1.0) -> Segment:
    """A sine or triangle of whole periods, without field."""
    frequency = neat(frequency)
    periods = max(1, round(SHORTEST * frequency))
    road = {"kind": kind, "amplitude": limits.stroke, "frequency": frequency}
    return Segment(road, _OFF, round(periods / frequency, 2), level, tones=(frequency,))


def neat(value: float) -> float:
    """A number of three digits, as one would type it."""
    return float(f"{value:.3g}")


_OFF: Spec = {"kind": "constant", "level": 0.0}
