r"""What is proved of the scheduled state feedback: one quadratic function for every gain, schedule and fault.

The loop is the car (2.11) with the yield force asked for, c = -K s, and the leaky integral v of the acceleration that
stands for the body's velocity: six states. It is straight in K and in (f_2, f_2 f_3). Factors from `LEAST` to 1 fill
a figure of four corners, and the gains are mixtures of those of the regimes and of none at all. So what holds at these
corners holds for every fault and schedule between, however fast they change:

.. math::  A_{ij}^T P + P A_{ij} + \ldots < 0 \text{ with } \gamma_i, \qquad
           P_d - \Phi_{ij}^T P_d \Phi_{ij} > 0

where gamma_i bounds the gain from the road's rate to body acceleration, deflection and tyre in the sizes of
`state_lqr`, and Phi is the loop sampled, c held, at the corners alone. f_1 acts on the force that can be given.

Source: bounded real lemma as (6.24) of the thesis; vertices as 6.3.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from er_models.exact import exact, is_positive_definite
from er_models.forms.loss import Factors
from er_models.model import Array, Model
from scipy.linalg import expm

from er_ftc_controller.state_law import StateLaw
from er_ftc_controller.synthesis.state_lqr import car_of, sizes_of

LEAST = 0.5
"""Least factor f_2 and f_3 of the proof."""
CORNERS = ((1.0, 1.0), (1.0, LEAST), (LEAST, 1.0), (LEAST, LEAST))
"""Factors f_2 and f_3 at which it is proved: the corners of (f_2, f_2 f_3)."""


@dataclass(frozen=True, eq=False)
class StateProof:
    """P and P_sampled (6, 6), scaled; gamma of no gain and of each regime."""

    P: Array
    P_sampled: Array
    gammas: tuple[float, ...]


class Feedback(NamedTuple):
    """A scheduled state feedback, and what is proved of it."""

    law: StateLaw
    proof: StateProof


def law_of(model: Model, gains: Array, corner: float) -> StateLaw:
    """The law of gains (4, 5) on a vehicle; corner: of its leaky integral [rad/s]."""
    frequency, units = sizes_of(model)
    car, (slow, resonance, rough, leaking) = model.effects["quarter_car"], gains.tolist()
    body = (car["m_s"], car["m_us"], car["k_t"])
    every = (tuple(slow), tuple(resonance), tuple(rough), tuple(leaking))
    return StateLaw(every, body, corner, frequency, units[0])


@dataclass(frozen=True, eq=False)
class Loops:
    """Scaled loops, by gain and corner: A (g, 4, 6, 6); D (6,) of the road's rate, C (4, 3, 6) of what is weighed.

    rate: inverse unit of time [1/s]; scale (6,): of the states [SI].
    """

    A: Array
    D: Array
    C: Array
    rate: float
    scale: Array
    B: Array
    K: Array


def loops_of(model: Model, gains: Sequence[Array], corner: float) -> Loops:
    """Loops of no gain and of each gain (5,); corner: of the leaky integral [rad/s]."""
    frequency, (a, x, v, tyre, force) = sizes_of(model)
    rate = 2.0 * np.pi * frequency
    scale = np.array([x, v, tyre, v, force, v])
    read = np.eye(
        5, 6
    )  # what the law takes for the state: the leaky integral and the wheel below it
    read[1] = np.eye(6)[5]
    read[3] = np.eye(6)[5] - np.eye(6)[1] + np.eye(6)[3]
    K = np.array([np.zeros(6), *(k @ read for k in gains)]) * scale
    open_, weighed = [], []
    for f2, f3 in CORNERS:
        A5, B5, D5 = car_of(model, Factors(leakage=f2, deformation=f3))
        A = np.zeros((6, 6))
        A[:5, :5], A[5, :5], A[5, 5] = A5, A5[1], -corner
        open_.append(A / scale[:, None] * scale / rate)
        rows = np.vstack([A[1] / a, np.eye(6)[0] / x, np.eye(6)[2] / tyre])
        weighed.append(rows * scale)
    B = np.append(B5, 0.0) / scale / rate
    D = np.append(D5, 0.0) * v / scale / rate
    A = np.array([[each - np.outer(B, k) for each in open_] for k in K])
    return Loops(A, D, np.array(weighed), rate, scale, B, K)


def sampled(loops: Loops, sample: float) -> Array:
    """The loops over a sample [s], the goal held, (g, 4, 6, 6)."""
    found = np.empty_like(loops.A)
    for i, k in enumerate(loops.K):
        for j in range(len(CORNERS)):
            whole = np.zeros((7, 7))
            whole[:6, :6], whole[:6, 6] = loops.A[0, j], loops.B
            step = expm(whole * sample * loops.rate)
            found[i, j] = step[:6, :6] - np.outer(step[:6, 6], k)
    return found


def failed(loops: Loops, proof: StateProof, sample: float) -> str:
    """The first statement that does not hold exactly ('' for none)."""
    if not is_positive_definite(exact(proof.P)):
        return "P of the state feedback is not positive definite"
    for i, gamma in enumerate(proof.gammas):
        for j in range(len(CORNERS)):
            if not _bounded(loops.A[i, j], loops.D, loops.C[j], proof.P, gamma):
                return f"gamma {gamma:.4g} does not hold with gain {i} at f2, f3 = {CORNERS[j]}"
    return (
        ""
        if falls(loops, proof.P_sampled, sample)
        else "P_sampled of the state feedback does not fall"
    )


def falls(loops: Loops, P: Array, sample: float) -> bool:
    """Whether P (6, 6) falls along every loop sampled so [s], exactly."""
    whole = exact(P)
    steps = (exact(step) for row in sampled(loops, sample) for step in row)
    return is_positive_definite(whole) and all(
        is_positive_definite(whole - one.T @ whole @ one) for one in steps
    )


def _bounded(A: Array, D: Array, C: Array, P: Array, gamma: float) -> bool:
    """Whether P proves that the gain of (A, D, C) is below gamma, exactly."""
    A_, P_, D_, C_, g = exact(A), exact(P), exact(D[:, None]), exact(C), exact(gamma)
    fall = -(P_ @ A_ + A_.T @ P_) - C_.T @ C_ / g
    corner = np.array([[g.item()]], dtype=object)
    entry = -(P_ @ D_)
    return is_positive_definite(np.block([[fall, entry], [entry.T, corner]]))
