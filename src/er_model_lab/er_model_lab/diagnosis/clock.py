r"""Time or heat: whether the data tell which of the two an effect follows.

Where the power is steady, what fades with time and what fades with the heat of the work done are one, whatever they
scale. So the change that a named effect makes is made again by the other clock: with its own clock c and the other d

.. math:: r = J \delta + \alpha\, \Delta F\, (d / c - 1)

tells, in a straight line and whatever all else does, which share alpha of it the data would rather have by the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from er_models.effect import Effect, arguments
from er_models.model import Array, Model
from er_models.prediction import predict

from er_model_lab.diagnosis.candidates import Candidate, effect_size
from er_model_lab.diagnosis.passing import passes
from er_model_lab.diagnosis.search import Round
from er_model_lab.diagnosis.ties import DOUBT, NEARLY
from er_model_lab.filtering import fading
from er_model_lab.problem.forward import Past
from er_model_lab.problem.problem import Problem

MIDWAY = 0.5
"""Share from which on the other clock is the likelier."""


def slow(effect: Effect) -> str:
    """Name of the one time constant of an effect of heat and ageing; empty for any other effect."""
    found = [q.name for q in effect.parameters if q.unit == "s"]
    return found[0] if effect.stage == "heat" and len(found) == 1 else ""


def follows_time(effect: Effect) -> bool:
    """Whether it follows the time itself, and not a state that warms."""
    return any("t" in arguments(hook) for hook in effect.hooks.values())


def clock_ties(
    best: Candidate, rounds: Sequence[Round], known: Sequence[Sequence[str]], problem: Problem
) -> tuple[tuple[str, ...], ...]:
    """Effects of heat and ageing in a model, each with the best of the other clock where the data do not tell which.

    known: groups that are tied anyhow.
    """
    catalogue, past = best.fit.model.catalogue, problem.forward.past(problem)
    if past is None:
        return ()
    groups = []
    for step in rounds:
        if step.taken is None or step.taken.name not in best.effects:
            continue
        taken = catalogue[step.taken.name]
        others = [n for n in _near(step) if follows_time(catalogue[n]) != follows_time(taken)]
        told = any(taken.name in group and {*group} & {*others} for group in known)
        if slow(taken) and others and not told and _undecided(best, taken, past, problem):
            groups.append((taken.name, others[0]))
    return tuple(groups)


def second_clocks(best: Candidate) -> tuple[str, ...]:
    """Effects of heat and ageing that were added beside another one.

    What warms thins by no equation exactly, and a second slow effect makes up for the form of the first.
    """
    model = best.fit.model
    held = [name for name in model.effects if slow(model.catalogue[name])]
    added = [name for name in held if name in best.effects]
    return tuple(added[1:] if len(added) == len(held) else added)


def _near(step: Round) -> list[str]:
    """Effects of heat and ageing that come near the one that a round took, best first."""
    assert step.taken is not None
    least = NEARLY * effect_size(step.base, step.taken)
    return [
        c.name
        for c in step.candidates
        if slow(c.fit.model.catalogue[c.name])
        and passes(step.base, c, step.threshold)
        and effect_size(step.base, c) >= least
    ]


def _undecided(best: Candidate, effect: Effect, past: Past, problem: Problem) -> bool:
    """Whether the other clock may be the true one of an effect in a model, as far as the data tell."""
    model, train = best.fit.model, problem.train
    change = problem.predict(model) - problem.predict(model.without_effect(effect.name))
    clocks = _clocks(model, effect, past)
    own, other = clocks if follows_time(effect) else clocks[::-1]
    twin = change * (np.divide(other, own, out=np.ones_like(own), where=own > 0.0) - 1.0)
    j = best.fit.jacobian[train][:, ~best.fit.at_bound]
    outside = twin[train] - j @ np.linalg.lstsq(j, twin[train], rcond=1e-10)[0]
    power, r = max(float(outside @ outside), 1e-300), best.fit.residual[train]
    share = float(outside @ r) / power
    scores = np.bincount(np.flatnonzero(train) // problem.second, outside * (r - share * outside))
    return share + DOUBT * float(np.sqrt(np.sum(scores**2))) / power > MIDWAY


def _clocks(model: Model, effect: Effect, past: Past) -> tuple[Array, Array]:
    """Time and heat (n,) [W]: what a wall has taken up since each record began, of the mean power and of the power."""
    motion, rows = past
    constant = model.value(effect.name, slow(effect))
    power, keeps = np.abs(predict(model, motion) * motion.v), np.exp(-motion.dt / constant)
    records = [power[i:j] for i, j in pairwise(motion.starts)]
    heat = np.concatenate([fading((1.0 - keeps) * p, keeps) for p in records])
    return power.mean() * (1.0 - np.exp(-motion.t[rows] / constant)), heat[rows]
