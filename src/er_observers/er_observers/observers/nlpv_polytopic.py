"""NLPV polytopic observer of the damper force: gains at both ends of the duty's range, one Lyapunov function.

Gains by `load_gains`; `start` and `step` are those of every observer (`runtime`).

Source: thesis section 4.3.2 and `er_observers.synthesis.nlpv_polytopic`.
"""

from __future__ import annotations

from pathlib import Path

from er_models.model import Model

from er_observers.gains import Gains
from er_observers.observers.ready import ready
from er_observers.observers.runtime import Estimate, Sample, State, start, step
from er_observers.observers.status import LIMITS, Limits

__all__ = ["NAME", "Estimate", "Sample", "State", "load_gains", "start", "step"]

NAME = "nlpv_polytopic"


def load_gains(path: str | Path, model: Model, limits: Limits = LIMITS) -> Gains:
    """Gains of this observer for this model, proved again, and the observer compiled.

    Raises `InputError` in one line when they are not (see `er_observers.gains`).
    """
    return ready(path, model, NAME, limits)
