"""A fault estimator ready to run: its compiled part is warm."""

from __future__ import annotations

from er_models.constants import SAMPLE_TIME
from er_models.model import Model

from er_observers.faults import tick
from er_observers.faults.estimator import start, step
from er_observers.faults.rules import RULES, Estimator, Rules, estimator
from er_observers.faults.sample import Sample


def ready(
    model: Model,
    rules: Rules = RULES,
    force_noise: float | None = None,
    sample_time: float = SAMPLE_TIME,
) -> Estimator:
    """As `rules.estimator`, and raises as it does."""
    p = estimator(model, rules, force_noise, sample_time)
    state = start(p, Sample(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    for k in range(1, round((p.rules.least + 2) * tick.WITHIN)):
        state, _ = step(p, state, Sample(sample_time * k, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    return p
