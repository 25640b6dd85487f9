"""Time or heat: what fades with either is a tie where the power is steady, and no tie where it is not."""

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline, refit
from er_model_lab.diagnosis.clock import clock_ties
from er_model_lab.diagnosis.investigation import search_effects
from er_model_lab.diagnosis.null import Null
from er_model_lab.diagnosis.search import Round
from er_models.files import load_model
from lab_help import DT, GUO, problem_of
from scipy.signal import lfilter

SECONDS, LOST, SLOW = 60.0, 0.2, 25.0
FADES = ("self_heating", "effectiveness_fade", "force_fade")


def left(clock):
    """What is left of a force (n,), as a hyperbola of a clock that ends where a fifth is lost."""
    return 1.0 / (1.0 + LOST / (1.0 - LOST) * clock / clock[-1])


def time(n):
    """A clock that runs with the time, towards an end."""
    return 1.0 - np.exp(-np.arange(n) * DT / SLOW)


def warmth(power):
    """A clock that runs with the power."""
    share = DT / SLOW
    return lfilter([share], [1.0, share - 1.0], power)


def whole(force, x):
    """The whole force fades with time, the springs too."""
    del x
    return force * left(time(force.size))


def flow(clock):
    """What the fluid carries fades, the springs do not; clock: of the power or of the samples."""

    def bent(force, x):
        springs = load_model(GUO).value("passive", "k0") * x
        runs = time(x.size) if clock == "time" else warmth(np.abs(force * np.gradient(x, DT)))
        return springs + (force - springs) * left(runs)

    return bent


def round_of(problem, model, names=FADES):
    """One round of a search among a few effects that takes the best."""
    base = baseline(model, problem)
    found = sorted(
        (refit(base, model.catalogue[n], problem, max_iter=20) for n in names), key=lambda c: c.mse
    )
    return Round(base, found, Null(np.zeros(0), 0.0, 1.0, 0.0, np.zeros(0)), 0.02, found[0], [])  # fmt: skip


@pytest.mark.slow
def test_a_force_that_fades_as_a_whole_is_no_heat():
    model, problem = problem_of(None, {}, seconds=SECONDS, bent=whole)
    found = search_effects(model, problem)
    named = {found.effects, *found.alternatives}
    assert found.effects == ("force_fade",)
    assert named <= {("force_fade",), ("force_fade", "self_heating")}


@pytest.mark.parametrize("clock", ["time", "heat"])
def test_what_scales_like_heat_is_heat_only_where_the_data_tell_it_from_the_time(clock):
    model, problem = problem_of(None, {}, seconds=SECONDS, bent=flow(clock))
    step = round_of(problem, model)
    assert step.taken.name == "self_heating"
    tied = clock_ties(step.taken, [step], (), problem)
    assert tied == ((("self_heating", "force_fade"),) if clock == "time" else ())
