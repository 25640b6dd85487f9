"""Fixed-step Runge-Kutta of order four for car or rig, duty held between samples."""

from __future__ import annotations

import numpy as np

from test.blind import rates
from test.blind.jit import Array, entry, inner
from test.blind.slots import (
    AM1,
    AM2,
    DEAD_TIME,
    DIRECTION,
    FER,
    FLD,
    INERTIA,
    LEFT,
    MX1,
    MX2,
    N_MEMORY,
    N_OUT,
    N_STATES,
    OAS,
    OAU,
    OF,
    OFER,
    OTH,
    OV,
    OVS,
    OVU,
    OX,
    OXD,
    OZS,
    OZU,
    STROKE,
    TF,
    TURN,
    VD,
    VOID,
    VS,
    VU,
    WHOLE_FADE,
    XD,
    ZS,
    ZU,
)
from test.blind.truth import force_fade, joint

SUBSTEPS = 32
SAMPLE = 0.005
STEP = SAMPLE / SUBSTEPS
LEAD_SAMPLES = 200
_SHORTEST_STROKE = 2e-4


@inner
def _evaluate(
    rig: int,
    t: float,
    i: int,
    drive: Array,
    u: float,
    burst: float,
    y: Array,
    dy: Array,
    memory: Array,
    rows: Array,
    base: Array,
    masses: Array,
) -> float:
    """Fill dy (N_STATES,); returns the force [N]. ``drive[i]`` is the road, or x, v, a."""
    if rig:
        outer = 0.0 if joint.present(rows) else rows[INERTIA, 0] * drive[i, 2]
        force = rates.damper(t, drive[i, 0], drive[i, 1], u, burst, y, dy, memory, rows, base)
        return float(force + outer)
    x, v = y[ZS] - y[ZU], y[VS] - y[VU]
    force = rates.damper(t, x, v, u, burst, y, dy, memory, rows, base)
    return rates.car(force, drive[i, 0], y, dy, rows, masses)


@inner
def _store(out: Array, j: int, rig: int, drive: Array, force: float, y: Array, dy: Array) -> None:
    """Row j of the fine trajectory, (n, N_OUT)."""
    out[j, OF], out[j, OXD], out[j, OFER], out[j, OTH] = force, y[XD], y[FER], y[TF]
    if rig:
        out[j, OX], out[j, OV], out[j, OAS] = drive[2 * j, 0], drive[2 * j, 1], drive[2 * j, 2]
        return
    out[j, OX], out[j, OV] = y[ZS] - y[ZU], y[VS] - y[VU]
    out[j, OAS], out[j, OAU] = dy[VS], dy[VU]
    out[j, OVS], out[j, OVU], out[j, OZS], out[j, OZU] = y[VS], y[VU], y[ZS], y[ZU]


@inner
def _shift(z: Array, y: Array, step: float, rate: Array) -> None:
    """Set z = y + step * rate."""
    for i in range(N_STATES):
        z[i] = y[i] + step * rate[i]


@inner
def _remember(memory: Array, x: float, v: float) -> None:
    """At a turning point, keep the length of the stroke that ended."""
    direction = 1.0 if v > 0.0 else -1.0
    if direction == memory[DIRECTION]:
        return
    length = abs(x - memory[TURN])
    if length > _SHORTEST_STROKE:
        memory[STROKE] = length
        memory[TURN] = x
    memory[DIRECTION] = direction


@inner
def _start(y: Array, rig: int, drive: Array, duty: float) -> None:
    """Set y from rest, or to the imposed motion's first point with every inner travel there."""
    y[AM1] = y[AM2] = duty
    y[FLD] = duty
    if rig:
        y[XD] = y[MX1] = y[MX2] = drive[0, 0]
        y[VD] = drive[0, 1]


@entry
def run(
    rig: int, drive: Array, duty: Array, burst: Array, rows: Array, base: Array, masses: Array
) -> Array:
    """Trajectory on the fine grid, (n * SUBSTEPS + 1, N_OUT), from LEAD_SAMPLES before t = 0.

    ``drive`` is (2 n SUBSTEPS + 1, 3) at half steps, ``duty`` (n,) per sample, ``burst`` (n,) in
    0..1.
    """
    steps = duty.size * SUBSTEPS
    delay = round(rows[DEAD_TIME, 0] / STEP)
    out = np.zeros((steps + 1, N_OUT))
    y, memory = np.zeros(N_STATES), np.zeros(N_MEMORY)
    _start(y, rig, drive, duty[0])
    k1, k2, k3 = np.zeros(N_STATES), np.zeros(N_STATES), np.zeros(N_STATES)
    k4, z = np.zeros(N_STATES), np.zeros(N_STATES)
    for j in range(steps):
        t = j * STEP - LEAD_SAMPLES * SAMPLE
        u, b = duty[max(j - delay, 0) // SUBSTEPS], burst[j // SUBSTEPS]
        memory[LEFT] = force_fade.factor(t, rows[WHOLE_FADE, 0], rows[WHOLE_FADE, 1])
        force = _evaluate(rig, t, 2 * j, drive, u, b, y, k1, memory, rows, base, masses)
        _store(out, j, rig, drive, force, y, k1)
        _shift(z, y, 0.5 * STEP, k1)
        _evaluate(rig, t + 0.5 * STEP, 2 * j + 1, drive, u, b, z, k2, memory, rows, base, masses)
        _shift(z, y, 0.5 * STEP, k2)
        _evaluate(rig, t + 0.5 * STEP, 2 * j + 1, drive, u, b, z, k3, memory, rows, base, masses)
        _shift(z, y, STEP, k3)
        _evaluate(rig, t + STEP, 2 * j + 2, drive, u, b, z, k4, memory, rows, base, masses)
        for i in range(N_STATES):
            y[i] += STEP / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
        y[VOID] = max(y[VOID], 0.0)
        _remember(memory, out[j, OX], out[j, OV])
    u, t = duty[-1], steps * STEP - LEAD_SAMPLES * SAMPLE
    force = _evaluate(rig, t, 2 * steps, drive, u, 0.0, y, k1, memory, rows, base, masses)
    _store(out, steps, rig, drive, force, y, k1)
    return out
