"""The peers of the observers: each does what its file says, and tuning and comparison run."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from er_models.files import load_model
from er_studies.observers import classes_command
from er_studies.observers.classes import scenario, with_noise
from er_studies.observers.nrmse import nrmse
from er_studies.observers.peers import known, tune
from er_studies.observers.run import follow
from er_studies.observers.scenarios.drive import drive
from typer.testing import CliRunner

CONFIG = Path(__file__).resolve().parents[3] / "config"


@pytest.fixture(scope="module")
def car():
    """The quarter car of Table 2.1."""
    return load_model(CONFIG / "vehicles" / "inove_quarter_car.yaml")


@pytest.fixture(scope="module")
def record(car):
    """Four seconds of class C, without noise of the accelerometers."""
    s = with_noise(scenario("C", "healthy", 8901, 4.0), 1e-3)
    return drive(replace(s, sensors=replace(s.sensors, noise=0.0)), car)


@pytest.mark.parametrize(
    ("name", "most"),
    [("balance", 1e-4), ("momentum", 0.05), ("ekf_5", 0.01), ("ukf_5", 0.01), ("horizon", 0.02)],
)
def test_each_follows_a_healthy_car(car, record, name, most):
    made = {e.name: e for e in known.tuned_peers(car, CONFIG / "peers.yaml")}[name]
    rows = record["t"] >= 2.0
    assert nrmse(record["damper_force"][rows], follow(made, record, None).force[rows]) < most


def test_tuning_finds_better_and_spends_its_budget(car, record, monkeypatch):
    tried = []
    score = tune.score
    monkeypatch.setattr(tune, "score", lambda *a: tried.append(score(*a)) or tried[-1])
    values = tune.tuned("momentum", car, 6, [record])
    assert len(tried) == 6
    assert score("momentum", car, values, [record]) == pytest.approx(min(tried), rel=1e-2)


def test_the_file_is_made_by_one_command(tmp_path):
    """`er study tune_peers` with one trial of each."""
    out = tmp_path / "peers.yaml"
    words = ["--config", str(CONFIG), "--out", str(out), "--budget", "1"]
    assert CliRunner().invoke(tune.app, words).exit_code == 0
    assert yaml.safe_load(out.read_text())["peers"].keys() == known.PEERS.keys()
    assert [
        e.name
        for e in known.tuned_peers(load_model(CONFIG / "vehicles" / "inove_quarter_car.yaml"), out)
    ]


def test_comparison_prints_a_table(tmp_path):
    """`er study classes` of one class."""
    words = ["--config", str(CONFIG), "--classes", "A", "--case", "healthy", "--noise", "200"]
    result = CliRunner().invoke(
        classes_command.app, [*words, "--json", str(tmp_path / "found.json")]
    )
    assert result.exit_code == 0, result.output
    assert "| 200 um, A, healthy |" in result.output
    assert np.isfinite(float(result.output.splitlines()[-1].split("|")[-2]))
