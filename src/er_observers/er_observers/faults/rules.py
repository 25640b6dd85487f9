"""What the fault estimator believes beforehand, when it says something, and a damper model prepared for it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from er_models.constants import SAMPLE_TIME
from er_models.errors import InputError
from er_models.model import Array, Model
from er_models.static_damper import StaticDamper, static_damper

from er_observers.faults import decision, tick
from er_observers.faults.sums import SIZE, TRIANGLE, N


@dataclass(frozen=True, slots=True)
class Rules:
    """What is believed and when something is said.

    tolerance: relative deviation of every parameter of damper and body. hold: time without samples until the estimate
    is invalid [s]. sure: probability that names a kind, in `blocks` blocks in a row. smallest: loss that is a fault.
    known, lost: deviation of a factor below which it is estimated and above which it is no longer excited. limit: rms
    residual over noise, and belief: deviations of an unknown from what was believed, that are in doubt; again: test
    ratio below which that is over; lasting: blocks of doubt after which something is unexplained. colour: how often
    neighbouring residuals say the same. cut: misfit of a block over that of the window that begins a new window;
    least: blocks before a verdict; calm: blocks in the window while all is well; fresh: blocks too young to learn from
    when the window is cut; anew: blocks after a cut in which all samples since then are followed again. memory: how
    long lessons last [s]; settle: pace of the mean square of the velocity [1/s]. healthy, single, combined:
    probabilities before any sample. road: how fast the road may be, over the greatest velocity of the damper; real: rms
    velocity over its deviation from which samples count.
    """

    tolerance: float = 0.05
    hold: float = 0.05
    sure: float = 0.95
    blocks: float = 4.0
    smallest: float = 0.06
    known: float = 0.08
    lost: float = 0.12
    limit: float = 1.5
    belief: float = 2.5
    again: float = 0.85
    lasting: float = 30.0
    colour: float = 1.5
    cut: float = 3.0
    least: float = 3.0
    calm: float = 15.0
    fresh: float = 5.0
    memory: float = 60.0
    healthy: float = 0.85
    single: float = 0.04
    combined: float = 0.03
    settle: float = 10.0
    road: float = 4.0
    anew: float = 10.0
    real: float = 20.0


RULES = Rules()
"""Rules for a car of the size of the thesis's rig up to a real one."""


@dataclass(frozen=True, eq=False)
class Estimator:
    """A damper model prepared for the estimation; arrays as the compiled part of `tick` takes them.

    limits: largest believable acceleration [m/s2], deflection [m], velocity [m/s] and force [N].
    """

    rules: Rules
    p: Array
    noise: Array
    setup: Array
    judging: Array
    prior: Array
    first: Array
    room: Array
    limits: tuple[float, float, float, float]


def estimator(
    model: Model,
    rules: Rules = RULES,
    force_noise: float | None = None,
    sample_time: float = SAMPLE_TIME,
) -> Estimator:
    """Prepare a vehicle model for samples so far apart [s].

    force_noise [N]: standard deviation of a given force; None where none is given and the sprung mass says it.
    Raises `InputError` where the model is no car, or its damper has terms that (6.8) does not know.
    """
    if not model.is_vehicle:
        raise InputError(model.name, "effects.quarter_car", "a vehicle model", "a damper only")
    damper, car = static_damper(model), model.effects["quarter_car"]
    given, sizes = force_noise is not None, _noise(model, rules)
    tau = model.effects["response"]["tau"] if "response" in model.effects else 0.0
    seen = car["m_s"] * sizes[0] if force_noise is None else force_noise
    s = model.scales
    return Estimator(
        rules, _constants(damper, tau, car), sizes,
        _setup(rules, force_noise or 0.0, seen, sample_time), _judging(rules),
        *_belief(model, rules.tolerance, with_body=not given), np.zeros(tick.ROOM),
        (100.0 * s.acceleration, 100.0 * s.deflection, 100.0 * s.velocity, 100.0 * s.force),
    )  # fmt: skip


def _setup(r: Rules, force_noise: float, seen: float, sample_time: float) -> Array:
    """Set-up (10,) of `tick`.

    force_noise [N]: of a given force, 0 for none; seen [N]: deviation of the force, however it is seen;
    sample_time [s].
    """
    setup = np.full(tick.SETUP, math.nan)
    setup[tick.FORCE], setup[tick.VARIANCE] = force_noise, seen**2
    setup[tick.CUT], setup[tick.LEAST] = r.cut, r.least
    setup[tick.KEPT] = math.exp(-(sample_time * tick.WITHIN) / r.memory)
    setup[tick.FADING] = min(sample_time * r.settle, 1.0)
    setup[tick.REAL] = r.real**2
    setup[tick.CALM], setup[tick.FRESH], setup[tick.ANEW] = r.calm, r.fresh, r.anew
    return setup


def _judging(r: Rules) -> Array:
    """Rules (11,) of `decision`."""
    judging = np.full(decision.RULES, math.nan)
    judging[decision.SURE], judging[decision.BLOCKS_IN_A_ROW] = r.sure, r.blocks
    judging[decision.SMALLEST] = r.smallest
    judging[decision.KNOWN], judging[decision.LOST] = r.known, r.lost
    judging[decision.LIMIT], judging[decision.BELIEF] = r.limit, r.belief
    judging[decision.COLOUR], judging[decision.AGAIN] = r.colour, r.again
    judging[decision.HEALTHY_ODDS] = r.healthy / r.single
    judging[decision.COMBINED_ODDS] = r.combined / r.single
    return judging


def _constants(damper: StaticDamper, tau: float, car: Mapping[str, float]) -> Array:
    """Constants (11,) in the order of `regression`."""
    d = damper
    body = [car[name] for name in ("m_s", "k_s", "m_us", "k_t")]
    return np.array([d.k0, d.c0, d.sigma, d.beta, d.k1, d.c1, tau, *body])


def _noise(model: Model, rules: Rules) -> Array:
    """Deviations (4,) of acceleration, deflection, velocity: of the rig, else shares of the envelope; see `follow`."""
    s = model.scales
    shares = {
        "acceleration": 1e-2 * s.acceleration, "deflection": 2e-3 * s.deflection, "velocity": 7e-3 * s.velocity,
    }  # fmt: skip
    sensors = [model.rig.get(f"{name}_noise", share) for name, share in shares.items()]
    return np.array([*sensors, rules.road * s.velocity])


def _belief(model: Model, tolerance: float, *, with_body: bool) -> tuple[Array, Array]:
    """What is believed of the unknowns before any sample: as a sum (SIZE,), and as means and deviations (2 N,).

    A wrong mass scales all of the sprung mass's row alike, so it joins the first four.
    """
    mean = np.zeros(N)
    mean[:3] = 1.0
    deviations = np.full(N, tolerance)
    deviations[4] = 0.1 * model.scales.force
    # a noisy velocity, and a road that bends within a sample, make any gate look wider
    deviations[5:] *= 2.0, 3.0, 3.0
    P = np.diag(deviations**2)
    if with_body:
        P[:4, :4] += tolerance**2
    information = np.linalg.inv(P)
    total = np.zeros(SIZE)
    total[:TRIANGLE] = information[np.tril_indices(N)]
    total[TRIANGLE : TRIANGLE + N] = information @ mean
    return total, np.concatenate([mean, np.sqrt(np.diag(P))])
