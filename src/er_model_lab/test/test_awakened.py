"""A term of the model's own that a fit had put to sleep is begun anew."""

from dataclasses import replace

import numpy as np
from er_model_lab.diagnosis.candidates import cross_judged, finished
from er_model_lab.fitting.fit import fit
from lab_help import FORCE_NOISE, problem_of


def test_a_yield_force_that_stood_in_for_another_effect_comes_back() -> None:
    """Seen on a pneumatic piston: bent towards the pressure, then left at zero, where its shape tells nothing."""
    model, problem = problem_of("field_preload", {"F_u": -400.0})
    yielding = {"f_c": 0.0, "k1": 975.0, "c1": 22.0}
    grown = model.with_effect("field_preload", {"F_u": -390.0})
    asleep = fit(replace(grown, effects={**grown.effects, "guo_yield": yielding}), problem)
    assert asleep.model.effects["guo_yield"]["f_c"] < 1e-9
    found = finished(cross_judged(("field_preload",), asleep, problem), problem)
    assert np.sqrt(asleep.mse(problem.train)) > 5.0 * FORCE_NOISE
    assert np.sqrt(found.seen) < 1.2 * FORCE_NOISE
    for name, value in found.fit.model.effects["guo_yield"].items():
        assert abs(value - model.effects["guo_yield"][name]) < 0.2 * abs(value), name
