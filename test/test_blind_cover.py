"""The coverage program draws fair truths, and counts intervals as it should."""

import json

import numpy as np
import pytest
from er_models.catalogue import CATALOGUE

from test.blind.measure import COLUMNS
from test.blind.refit import excess, refit
from test.blind_score import cover
from test.blind_score.cover import NAMES, SHARED, Estimate, blind, coverage, line, simulated
from test.blind_score.lab_truth import base_model, draw_truth, inside, moved, shape, write_noisy
from test.blind_score.program import seeds_of

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    "name", ["dead_time", "cavitation", "rise_fall_asymmetry", "self_heating"]
)
def test_a_truth_shows_as_much_as_stated(name):
    truth = draw_truth(name, 1, 2, 12.0)
    assert 0.1 <= truth.rise <= 6.0
    left = refit(truth.records, offset=True).rms
    assert excess(left, 0.15) == pytest.approx(truth.rise)
    assert inside(CATALOGUE[name], dict(truth.model.effects[name]), truth.model)
    assert truth.records[0]["t"].size == 2400
    again = draw_truth(name, 1, 2, 12.0)
    np.testing.assert_array_equal(
        again.records[1]["damper_force"], truth.records[1]["damper_force"]
    )


@pytest.mark.parametrize("name", NAMES)
def test_a_switch_at_zero_switches_off(name):
    """Amplitudes at zero distance from neutral give back the base model's own file of values."""
    effect, rng = CATALOGUE[name], np.random.default_rng(3)
    model = base_model(rng)
    point = shape(effect, model, rng)
    for q in effect.parameters:
        low, high = model.bounds(name, q.name)
        assert low <= point[q.name] <= high
    off = moved(effect, point, 1e-9, model)
    for q in effect.parameters:
        if q.neutral is not None and np.isfinite(q.neutral):
            neutral = q.neutral * model.scales.of(q.unit)
            assert off[q.name] == pytest.approx(neutral, abs=1e-6 * model.scales.of(q.unit))
        elif q.neutral is not None:
            assert abs(off[q.name]) == pytest.approx(1e6 * model.scales.of(q.unit))


def test_noise_is_written_with_the_contract_s_columns(tmp_path):
    truth = draw_truth("preload", 2, 2, 8.0)
    folder = write_noisy(truth, 2, tmp_path / "data")
    paths = sorted(folder.glob("*.csv"))
    assert len(paths) == 2
    assert paths[0].read_text().splitlines()[0] == ",".join(COLUMNS)
    found = np.loadtxt(paths[0], delimiter=",", skiprows=1)
    error = found[:, COLUMNS.index("damper_force")] - truth.records[0]["damper_force"]
    assert np.std(error) == pytest.approx(0.15, rel=0.05)


def test_intervals_are_counted():
    inner = Estimate("a", "p", 1.0, 1.19, 0.1)
    outer = Estimate("a", "p", 1.0, 1.21, 0.1)
    unknown = Estimate("a", "q", 1.0, 9.0, None)
    assert inner.z == pytest.approx(1.9)
    assert line("all", [inner, outer, unknown])[1] == "1/2"
    assert line("all", [inner, outer, unknown])[-1] == "1"
    text = coverage("title", [inner, outer, unknown])
    assert "| a p | 1/2 | 50.0% |" in text
    assert "| a q | 0/0 |" in text


def test_rows_become_estimates():
    row = {"effect": "dead_time", "parameters": {"T_d": [0.01, 0.011, 0.001]}}
    assert simulated([row, {"effect": "b", "failed": "why"}]) == [
        Estimate("dead_time", "T_d", 0.01, 0.011, 0.001)
    ]
    known = {
        "kind": "singles", "hidden": ["fluid_inertia"], "names": ["fluid_inertia"], "alternatives": [],
        "parameters": {"fluid_inertia": {"m_f": [0.2, 0.01, "kg"]}},
        "truth": {"fluid_inertia": {"m": {"value": 0.21, "unit": "kg"}}},
    }  # fmt: skip
    assert blind([known]) == [Estimate("fluid_inertia", "m_f", 0.21, 0.2, 0.01)]
    assert blind([{**known, "names": []}]) == []


def test_shared_parameters_exist():
    for effect, parameter in SHARED:
        assert parameter in CATALOGUE[effect].names


def test_bad_words(capsys):
    assert cover.main(["--effects", "colomb"]) == 2
    assert "found colomb" in capsys.readouterr().err
    assert seeds_of(["2", "4-6"]) == [2, 4, 5, 6]


def test_one_truth_through_the_whole_lab(tmp_path, capsys):
    out = tmp_path / "r.jsonl"
    words = ["--effects", "dead_time", "--seeds", "1", "--workers", "1", "--results", str(out)]
    assert cover.main(words) == 0
    row = json.loads(out.read_text())
    truth, value, sd = row["parameters"]["T_d"]
    assert abs(value - truth) < 5.0 * sd
    assert sd < 0.2 * truth
    assert "| dead_time T_d | " in capsys.readouterr().out
