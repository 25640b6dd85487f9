"""Motions that the sensors may have meant: the fused motion plus what fusion does not know.

A draw from the posterior of the motion (Durbin and Koopman 2002): a motion of the same model is driven by
noise, measured with fresh noise of every sensor and fused; by how much fusion misses it has the very law of
what it misses of the true motion, the noise between two samples included.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np
from er_models.model import Array
from er_models.prediction import Motion, Told, join

from er_model_lab.motion.chain import compiled, diffusion, transition
from er_model_lab.motion.fuse import Channels, Fused, as_measured, fuse


class Sensed(Protocol):
    """A motion and what it was made from: per record the channels that were measured, and what fusion made of them."""

    @property
    def motion(self) -> Motion:
        """All records, laid end to end."""

    @property
    def raw(self) -> tuple[Channels, ...]:
        """Measured channels of each record."""

    @property
    def fused(self) -> tuple[Fused, ...]:
        """Motion of each record, with the noise model it was fused by."""

    @property
    def told(self) -> Told:
        """What tells where the states of each record begin."""


@compiled
def _driven(transition: Array, pushes: Array) -> Array:
    """States (n, order) of a chain from rest, pushed once a sample."""
    out = np.zeros(pushes.shape)
    for k in range(1, pushes.shape[0]):
        for i in range(pushes.shape[1]):
            out[k, i] = pushes[k, i]
            for j in range(pushes.shape[1]):
                out[k, i] += transition[i, j] * out[k - 1, j]
    return out


def _wandering(channels: Channels, fused: Fused, rng: np.random.Generator) -> Array:
    """A motion x, v, a (n, 3) of the model of the motion, from rest."""
    noise, n = fused.noise, channels.z.shape[0]
    order, dt = noise.order, channels.dt
    size, root = np.linalg.eigh(diffusion(dt, order, 0.0, 5)[:order, :order])
    activity = channels.activity if noise.local else np.ones(n)
    pushes = rng.standard_normal((n, order)) * np.sqrt(np.maximum(size, 0.0)) @ root.T
    pushes *= np.sqrt(noise.drive * activity)[:, None]
    states = _driven(transition(dt, order, 0.0, 5)[:order, :order].copy(), pushes)
    return np.asarray(states[:, :3])


def missed(channels: Channels, fused: Fused, rng: np.random.Generator) -> Array:
    """One draw of true less fused motion: x [m], v [m/s] and a [m/s2] as (n, 3)."""
    noise = fused.noise
    true = np.stack([fused.x, fused.v, fused.a], axis=1) + _wandering(channels, fused, rng)
    x, v, a = np.ascontiguousarray(true.T)
    clean = as_measured(replace(fused, x=x, v=v, a=a), channels.dt)
    sd = np.array([noise.x, noise.v, noise.a])
    again = replace(channels, z=clean + rng.standard_normal(clean.shape) * sd)
    seen = fuse(again, noise, channels.spread)
    wrong = np.asarray(true - np.stack([seen.x, seen.v, seen.a], axis=1))
    return wrong if channels.has[0] else _about_its_middle(wrong, channels.dt)


def _about_its_middle(wrong: Array, dt: float) -> Array:
    """The same without a straight line: where no deflection was measured the motion is taken about its middle."""
    t = np.arange(wrong.shape[0]) * dt
    slope, _ = line = np.polyfit(t, wrong[:, 0], 1)
    return np.asarray(
        wrong - np.stack([np.polyval(line, t), np.full(t.size, slope), np.zeros(t.size)], axis=1)
    )


def drawn(data: Sensed, rng: np.random.Generator) -> Motion:
    """A motion that the sensors may have meant; accelerations that were not fused stay as measured."""
    m, parts = data.motion, []
    for r, (channels, fused) in enumerate(zip(data.raw, data.fused, strict=True)):
        i, j = m.starts[r], m.starts[r + 1]
        x, v, a = np.ascontiguousarray(missed(channels, fused, rng).T)
        if not channels.has[2] and channels.measured_a:
            a = np.zeros_like(a)
        part = replace(m, u=m.u[i:j], theta=m.theta[i:j], starts=np.array([0, j - i]))
        parts.append(replace(part, x=m.x[i:j] + x, v=m.v[i:j] + v, a=m.a[i:j] + a))
    return join(parts)
