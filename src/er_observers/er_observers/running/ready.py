"""Gains of an observer, loaded and ready to run: proved again, and the compiled part warm."""

from __future__ import annotations

import math
from pathlib import Path

from er_models.constants import SAMPLE_TIME
from er_models.model import Model

from er_observers import gains as gain_files
from er_observers.gains import Gains
from er_observers.observers.status import LIMITS, Limits
from er_observers.running.runtime import Sample, payload_of, start, step


def ready(
    path: str | Path, model: Model, observer: str | None = None, limits: Limits = LIMITS
) -> Gains:
    """Gains of an observer for this model as `load_gains` has them, with nothing left to compile in the loop.

    Raises `InputError` in one line when they are not (see `er_observers.gains`).
    """
    gains = gain_files.load_gains(path, model, observer, limits)
    rest = Sample(0.0, 0.0, 0.0, 0.0, 0.0)
    state, following = start(gains, rest), rest._replace(t=SAMPLE_TIME)
    for P in {id(m): m for m in (state.P, None)}.values():  # both phases
        # a lost sample goes another way: the first must not wait for a compiler in the loop
        for sample in (following, following._replace(sprung_acceleration=math.nan)):
            payload_of(gains, step(gains, state._replace(P=P), sample)[0])
    return gains
