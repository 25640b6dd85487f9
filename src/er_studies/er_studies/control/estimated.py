"""The fault estimator in the pure closed loop: what the controller is told where nobody knows the faults."""

from __future__ import annotations

from er_ftc_controller.control import Faults
from er_ftc_controller.opinion import opinion
from er_models.model import Model
from er_observers.faults import estimator
from er_observers.faults.rules import estimator as prepare
from er_observers.faults.sample import Estimate, Sample, Status

from er_studies.control.closed_loop import Told, Watch

TRUSTED = (Status.OK, Status.DEGRADED)


def estimated(believed: Model, _car: Model) -> Watch:
    """The estimator of the car that is believed in."""
    p = prepare(believed)

    def step(state: estimator.State | None, told: Told) -> tuple[estimator.State, Faults]:
        sample = Sample(*told[:6])
        if state is None:
            state = estimator.start(p, sample)
            return state, faults_of(told.t, state.estimate)
        state, estimate = estimator.step(p, state, sample)
        return state, faults_of(told.t, estimate)

    return Watch(lambda: None, step)


def faults_of(t: float, e: Estimate) -> Faults:
    """What an estimate says at t [s]."""
    trusted = e.status in TRUSTED and not e.unexplained
    return opinion(t, e.factors, [int(s) for s in e.states], trusted=trusted)
