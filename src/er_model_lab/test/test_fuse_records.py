"""Records of very different motion are fused each with its own intensity; the sensors are the same."""

from itertools import pairwise

import numpy as np
import pytest
from er_model_lab.problem.prepare import prepare
from er_records.dataset import Dataset
from er_records.record import Record

DT = 0.005
SD = {"deflection": 2e-5, "deflection_velocity": 1e-3, "sprung_acceleration": 0.025}


def sine(frequency, amplitude, seed, seconds=6.0):
    """A record of an imposed sine with the noise of the sensors, and its true velocity."""
    rng, t = np.random.default_rng(seed), np.arange(round(seconds / DT)) * DT
    w = 2 * np.pi * frequency
    true = {
        "deflection": amplitude * np.sin(w * t),
        "deflection_velocity": amplitude * w * np.cos(w * t),
        "sprung_acceleration": -amplitude * w**2 * np.sin(w * t),
    }
    channels = {k: y + SD[k] * rng.standard_normal(t.size) for k, y in true.items()}
    channels["unsprung_acceleration"] = SD["sprung_acceleration"] * rng.standard_normal(t.size)
    channels["damper_force"] = 60.0 * true["deflection_velocity"]
    channels["duty"] = np.zeros(t.size)
    return Record(f"{frequency:g} Hz", t, channels), true["deflection_velocity"]


@pytest.mark.parametrize("slow_first", [True, False])
def test_a_fast_record_beside_a_slow_one_keeps_its_velocity(slow_first):
    made = [sine(1.0, 0.009, 1), sine(4.0, 0.0055, 2), sine(2.0, 0.009, 3)]
    made = made if slow_first else made[::-1]
    problem = prepare(Dataset.of([record for record, _ in made]))
    for (i, j), (_, v) in zip(pairwise(problem.motion.starts), made, strict=True):
        inner = slice(20, -20)
        found, true = problem.motion.v[i:j][inner], v[inner]
        assert found @ true / (true @ true) == pytest.approx(1.0, abs=1e-3)
        assert np.std(found - true) < 0.25 * SD["deflection_velocity"]
    drives = [f.noise.drive for f in problem.fused]
    assert max(drives) > 100.0 * min(drives)
    assert len({(f.noise.x, f.noise.v, f.noise.a) for f in problem.fused}) == 1
