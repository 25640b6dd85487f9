"""How the fault estimator is judged on a drive: what happened, and what any estimator could have known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from er_models.model import Model
from er_observers.faults import regression
from er_observers.faults.rules import estimator
from er_observers.faults.sample import Kind
from er_studies.faults import bound
from er_studies.faults.acceptance import faultless, faulty
from er_studies.faults.trials import Trial, drive


def test_what_could_be_known_at_best(car: Model) -> None:
    """A factor alone is known as by its force and the body's noise; with more that is unknown it is worse."""
    p, record = estimator(car), drive(Trial(1005, duration=4.0, road="iso8608"), car)
    alone = bound.covariances(p, record, {"f2": 0.5}, [("f2",)], 1, [600], certain=True)
    force = np.linalg.norm([s.force for s in record.samples[1:600]])
    body = p.p[regression.M_S] * car.rig["acceleration_noise"]
    # the body's own sensor tells its acceleration, and so does the motion less the wheel's
    assert body / math.sqrt(2.0) < np.sqrt(alone[0, 0, 1, 1]) * force < 1.2 * body
    left, news = {"f2": 0.8}, [("f2",), bound.NAMES]
    known, open_ = (
        bound.covariances(p, record, left, news, 400, [600, 790], certain=certain)
        for certain in (True, False)
    )
    spread = [np.sqrt(each[:, :, 1, 1]) for each in (known, open_)]
    assert np.all(spread[0] < spread[1])
    assert np.all(spread[0][1] > 10.0 * spread[0][0])
    assert np.all(spread[1][:, 1] < spread[1][:, 0])
    assert open_[0, 0, 0, 0] == 0.0
    easy, hard = (bound.told_apart(open_[1, 1], {"f2": f}) for f in (0.5, 0.98))
    assert easy > 0.99
    assert 0.5 < hard < 0.75
    assert bound.chance(0.05, 0.05) == pytest.approx(0.6827, abs=1e-4)


def test_a_drive_is_judged_as_it_went(car: Model) -> None:
    p, trial = estimator(car), Trial(1004, {"f1": 0.6}, fault_time=5.0, duration=9.0)
    found = faulty(p, trial, car)
    assert found.kind is Kind.ELECTRICAL
    assert found.named < 2.0
    assert not found.wrong
    assert not found.early
    assert abs(found.errors["f1"]) < 0.1
    quiet = faultless(p, Trial(5000, spread=0.05, duration=5.0), car)
    assert (quiet.named, quiet.silent) == ((), ())
