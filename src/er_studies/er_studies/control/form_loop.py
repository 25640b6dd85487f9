"""One sample of the car on the Lipschitz form, and the loop of a peer, compiled: numbers alone, of no other package."""

from __future__ import annotations

import math

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array

from er_studies.control.peers.rule import duty
from er_studies.control.peers.sample import (
    A_S,
    A_U,
    AHEAD,
    FORCE,
    FULL,
    GATE,
    STEP,
    TYRE,
    V_S,
    WAY,
    V,
    X,
    compiled,
)  # fmt: skip

LEAK = 2.0 * math.pi * 0.1
"""Corner of the leaky integral of all peers [rad/s]."""
PER_STEP = round(STEP / DT)


@compiled
def advance(A: Array, inputs: Array, q: Array, rates: Array, u: float) -> None:
    """One sample of the car, in place."""
    h = DT / rates.size
    mid, slope = np.empty(5), np.empty(5)
    for rate in rates:
        for part in range(2):
            at = q if part == 0 else mid
            move = 0.0
            for j in range(5):
                move += inputs[2, j] * at[j]
            gate = u * math.tanh(move)
            for i in range(5):
                slope[i] = inputs[0, i] * gate + inputs[1, i] * rate
                for j in range(5):
                    slope[i] += A[i, j] * at[j]
            for i in range(5):
                if part == 0:
                    mid[i] = q[i] + 0.5 * h * slope[i]
                else:
                    q[i] += h * slope[i]


@compiled
def ridden(
    number: int, p: Array, A: Array, inputs: Array, outputs: Array, belief: Array, rates: Array, noise: Array,
    u_max: float, latency: int,
) -> Array:  # fmt: skip
    """The loop of a peer; sensors, what it follows, and its duty at each sample."""
    n, out, q, s = noise.shape[0], np.empty((noise.shape[0], 5)), np.zeros(5), np.zeros(10 + AHEAD)
    acting, pending, before, gate = 0.0, 0.0, 0.0, 0.0
    m_s, m_us, k_t, lag, full = belief
    kept, fades = math.exp(-DT * lag), math.exp(-DT * LEAK)
    time = 0.5 * DT + latency * DT
    s[FULL] = full
    for k in range(n):
        if k > 0:
            advance(A, inputs, q, rates[k - 1], acting)
        a_s, a_us, force = 0.0, 0.0, 0.0
        for j in range(5):
            a_s += outputs[0, j] * q[j]
            a_us += outputs[1, j] * q[j]
            force += outputs[2, j] * q[j]
        s[A_S], s[A_U] = a_s + noise[k, 0], a_us + noise[k, 1]
        s[X], s[V] = q[0] + noise[k, 2], q[1] - q[3] + noise[k, 3]
        s[V_S] = s[V_S] * fades + 0.5 * DT * (before + s[A_S])
        before = s[A_S]
        s[TYRE] = -(m_s * s[A_S] + m_us * s[A_U]) / k_t
        now = math.tanh(inputs[2, 0] * s[X] + inputs[2, 1] * s[V])
        s[FORCE] = s[FORCE] * kept + (1.0 - kept) * full * acting * 0.5 * (gate + now)
        gate, rate = now, s[A_S] - s[A_U]
        s[GATE] = math.tanh(
            inputs[2, 0] * (s[X] + time * (s[V] + 0.5 * time * rate))
            + inputs[2, 1] * (s[V] + time * rate)
        )
        for i in range(AHEAD):
            first = k + i * PER_STEP
            s[WAY + i] = (
                rates[first : first + PER_STEP].mean() if first + PER_STEP <= n - 1 else 0.0
            )
        wish = duty(number, p, s, u_max)
        if latency > 0:
            acting, pending = pending, wish
        else:
            acting = wish
        out[k, 0], out[k, 1], out[k, 2], out[k, 3], out[k, 4] = q[0], a_s, q[2], force, acting
    return out
