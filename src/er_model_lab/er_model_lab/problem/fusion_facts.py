"""What the fused motion rests on: channels, what is lost without the others, and the bias of each accelerometer.

The bias of the *relative* acceleration is a state of the smoother: deflection and velocity say how fast the motion
really changes. The bias of *one* accelerometer is not in them. It is the mean of the channel, as far as the body
ends as fast as it began: the mean of a true acceleration over a time T is the change of the velocity over T, and
the size of the velocity is known from the integral of the channel. Both statements together give each bias.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from er_records.missing_channels import ACCELEROMETERS, losses
from er_records.record import Array, Record

from er_model_lab.motion.fuse import Fused
from er_model_lab.problem.problem import Problem

BIASED = 3.0
"""Standard deviations from which a bias is said to be there."""

Estimate = tuple[float, float]


def drift(record: Record, channel: str) -> Estimate | None:
    """Mean of an accelerometer and what the change of the velocity may add to it [m/s2]; None without the channel."""
    if not record.has(channel):
        return None
    a = np.asarray(record.channels[channel])
    n, dt = a.size, record.dt
    velocity = np.cumsum(a - a.mean()) * dt
    t = np.arange(n) * dt
    swing = velocity - np.polyval(np.polyfit(t, velocity, 1), t)
    return float(a.mean()), float(np.sqrt(2.0 * np.mean(swing**2)) / (n * dt))


def _pooled(found: Sequence[Estimate]) -> Estimate | None:
    """Mean of estimates with their deviations, weighted by these; None where there is none."""
    good = [(v, max(sd, 1e-12)) for v, sd in found if np.isfinite(sd)]
    if not good:
        return None
    weight = np.array([1.0 / sd**2 for _, sd in good])
    value = float(np.sum(weight * np.array([v for v, _ in good])) / weight.sum())
    return value, float(1.0 / np.sqrt(weight.sum()))


def biases(records: Sequence[Record], fused: Sequence[Fused]) -> dict[str, Estimate | None]:
    """Bias of each accelerometer and of their difference [m/s2] with standard deviation; None: not to be known."""
    pooled = [
        _pooled([d for r in records if (d := drift(r, c)) is not None]) for c in ACCELEROMETERS
    ]
    relative = _pooled([(f.bias, f.bias_sd) for f in fused if "acceleration" in f.channels])
    own, rows, values = [p for p in pooled if p is not None], [], []
    if len(own) == 2 and relative is not None:
        for row, (value, sd) in zip(([1, 0], [0, 1], [1, -1]), (*own, relative), strict=True):
            rows.append(np.array(row) / sd)
            values.append(value / sd)
        j: Array = np.array(rows)
        covariance = np.linalg.inv(j.T @ j)
        best = covariance @ j.T @ np.array(values)
        sd = np.sqrt(covariance.diagonal())
        pooled = [(float(b), float(s)) for b, s in zip(best, sd, strict=True)]
    return {**dict(zip(ACCELEROMETERS, pooled, strict=True)), "relative": relative}


def fusion_json(records: Sequence[Record], problem: Problem) -> dict[str, Any]:
    """Channels, what they leave unknown of the motion, biases, and what is lost; plain data."""
    found = biases(records, problem.fused)
    fused = problem.fused
    return {
        "channels": sorted({c for f in fused for c in f.channels}),
        "sd": {
            "deflection": _mean([f.sd_x for f in fused]), "velocity": _mean([f.sd_v for f in fused]),
            "acceleration": _mean([f.sd_a for f in fused]),
        },
        "noise": {
            name: getattr(problem.noise, key) if any(c.has[k] for c in problem.raw) else None
            for k, (name, key) in enumerate((("deflection", "x"), ("velocity", "v"), ("acceleration", "a")))
        },
        "bias": {
            name: {"value": None, "sd": None, "says": _unknown(name)} if e is None
            else {"value": e[0], "sd": e[1], "says": _known(name, e)}
            for name, e in found.items()
        },
        "lost": list(losses(records)),
    }  # fmt: skip


def _mean(values: Sequence[float]) -> float | None:
    """Mean, None of nothing."""
    return float(np.mean(values)) if len(values) else None


def _known(name: str, e: Estimate) -> str:
    """How a bias is known, and whether it is there."""
    there = "biased" if abs(e[0]) > BIASED * e[1] else "no bias beyond its deviation"
    if name == "relative":
        return f"{there}; against deflection and velocity"
    return f"{there}; taken that the mass ends as fast as it began (a slope of the road looks the same)"


def _unknown(name: str) -> str:
    """Why a bias cannot be known."""
    return (
        "needs both accelerations beside deflection or velocity"
        if name == "relative"
        else "channel absent"
    )
