"""The lab's benchmark finds what it hides, counts what it tries, and draws what it measured."""

import json
from pathlib import Path

import numpy as np
import pytest
from er_models.files import load_model
from er_studies.bench.lab.__main__ import main
from er_studies.bench.lab.data import record
from er_studies.bench.lab.measure import Few, Line
from er_studies.bench.lab.picture import picture

GUO = Path(__file__).resolve().parents[3] / "config" / "dampers" / "inove_guo.yaml"


@pytest.mark.slow
def test_the_search_is_timed_over_the_number_of_effects(tmp_path, capsys):
    main(["number", "--tiny", "--model", str(GUO), "--json", str(tmp_path / "r.json")])
    lines = json.loads((tmp_path / "r.json").read_text())["number"]
    assert [x["n"] for x in lines[:2]] == [2, 3]
    assert lines[-1]["n"] > 20
    assert all(x["found"] == "coulomb_friction" and x["wall"] > 0.0 for x in lines)
    assert "| 2 effects |" in capsys.readouterr().out


def test_few_candidates_are_few_and_hold_the_hidden_one():
    names = [e.name for e in Few(3).candidates(load_model(GUO))]
    assert len(names) == 3
    assert "coulomb_friction" in names


def test_the_motion_is_consistent_and_within_the_envelope():
    model = load_model(GUO)
    made = record(model, 20.0)
    v = made.channels["deflection_velocity"]
    assert 0.3 * model.scales.velocity < np.abs(v).max() < model.scales.velocity
    slope = np.gradient(made.channels["deflection"], made.t)
    assert np.std(slope - v) < 0.2 * np.std(v)


def test_the_picture_holds_both_panels(tmp_path):
    lines = [Line(f"{n} s", n, 0.1 * n, 0.2 * n, "", 0.1) for n in (10.0, 20.0, 60.0)]
    picture(lines, lines, tmp_path / "cost.svg")
    text = (tmp_path / "cost.svg").read_text()
    assert "length of the data" in text
    assert "effects tried" in text
