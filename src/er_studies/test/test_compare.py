"""The comparison measures what it says."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from er_observers.programs import OBSERVERS
from er_studies.observers.command import app
from er_studies.observers.estimators import estimators_of
from er_studies.observers.floor import floor_of
from er_studies.observers.nrmse import nrmse, settling_time
from er_studies.observers.run import Outcome, compare, road_outcomes
from er_studies.observers.scenarios.drive import drive
from er_studies.observers.scenarios.files import choose_scenarios, load_scenarios
from er_studies.observers.scenarios.scenario import Plant, Sensors
from er_studies.observers.table import paired, ratio_to_peers, rows_of
from typer.testing import CliRunner

CONFIG = Path(__file__).resolve().parents[3] / "config"


def test_nrmse_by_hand():
    """(3.79)-(3.80): rms of (3, 0, 0, 3) is 3 / sqrt 2, the true force spans 8."""
    true = np.array([-4.0, 0.0, 1.0, 4.0])
    assert nrmse(true, true + [3.0, 0.0, 0.0, -3.0]) == pytest.approx(3.0 / np.sqrt(2.0) / 8.0)


def test_settling_by_hand():
    """An error of 1 on a range of 10 until 0.5 s, nothing after: its rms over 0.1 s fades until 0.595 s."""
    t = 0.005 * np.arange(400)
    true = np.where(t < 1.0, 10.0, 0.0)
    assert settling_time(t, true, true) == 0.0
    assert settling_time(t, true, true + (t < 0.5)) == pytest.approx(0.595)
    assert settling_time(t, true, true + 1.0) == np.inf


def test_rows_hold_medians_and_ratios():
    (s,) = choose_scenarios(load_scenarios(CONFIG / "scenarios"), ["wrong_parameters"])
    errors = {"mine": (3.0, 1.0, 2.0), "ekf": (1.0, 1.0, 9.0), "ukf": (4.0, 4.0, 4.0)}
    made = [
        Outcome(s.name, k, name, (values[k],), 0.0, 0.0)
        for name, values in errors.items()
        for k in range(3)
    ]
    (row,) = rows_of([s], made)
    assert row.errors == {"mine": 2.0, "ekf": 1.0, "ukf": 4.0}
    assert row.worst["ekf"] == 9.0
    assert row.roads == 3
    assert ratio_to_peers(row, "mine", ["ekf", "ukf"]) == 2.0


def test_paired_interval_by_hand():
    """Of 20 roads the 6th and the 15th difference enclose the median in 95.9 % of all cases; of 5 none do."""
    (s,) = choose_scenarios(load_scenarios(CONFIG / "scenarios"), ["wrong_parameters"])
    made = [
        Outcome(s.name, k, name, (k + more * k,), 0.0, 0.0)
        for name, more in (("mine", 1.0), ("worse", 3.0), ("ekf", 0.0))
        for k in range(20)
    ]
    (row,) = rows_of([s], made)
    assert paired(row, ["mine", "worse"]) == (9.5, 5.0, 14.0)
    (few,) = rows_of([s], [o for o in made if o.number < 5])
    assert paired(few, ["mine"]) is None


@pytest.mark.parametrize(
    ("name", "ours", "filters"),
    [
        (
            "hidden_effects/sprung_mass_error",
            (0.0, 0.3),
            (0.9, 1.05),
        ),  # ours believe another mass soon
        ("wrong_sensors_delay", (0.95, 1.05), (0.95, 1.05)),
        ("hidden_effects/asymmetric_damping", (0.0, 0.5), (1.2, 2.0)),  # and other damping
    ],
)
def test_errors_beside_what_the_belief_leaves(car, name, ours, filters):
    """A wrong mass and late sensors are all of the error; who believes the truth has none of it.

    Where the road is straight between samples: else two accelerometers do not tell a mass so well.
    """
    (s,) = choose_scenarios(load_scenarios(CONFIG / "scenarios"), [name])
    road = {**s.program.road, "straight": 0.005}
    s = replace(s, program=replace(s.program, road=road, duration=6.0))
    estimators = [e for e in estimators_of(car, CONFIG / "gains") if e.name in ("unified", "ukf")]
    for outcome in road_outcomes(s, 0, car, estimators):
        least, most = filters if outcome.estimator == "ukf" else ours
        assert least < outcome.errors[0] / outcome.floors[0] < most
    right = replace(s, plant=Plant(), sensors=Sensors())
    assert floor_of(right, s.windows[0], drive(right, car), car) < 0.003


@pytest.fixture(scope="module")
def outcomes(car):
    """Friction hidden in the plant, and nothing wrong, a road of each."""
    names = ["hidden_effects/coulomb_friction", "chapter_5_noise_equal"]
    chosen = choose_scenarios(load_scenarios(CONFIG / "scenarios"), names)
    return rows_of(chosen, compare(chosen, car, CONFIG / "gains", seeds=1))


def test_ours_keeps_up_with_the_peers_once_running(outcomes):
    for row in outcomes:
        if row.window.begin == 2.0:
            ours = [n for n in row.errors if n not in ("ekf", "ukf")]
            assert ours
            assert all(ratio_to_peers(row, n, ["ekf", "ukf"]) < 1.1 for n in ours)


def test_what_is_hidden_costs_everyone(outcomes):
    friction = next(r for r in outcomes if "friction" in r.scenario.name)
    plain = next(r for r in outcomes if r.window.begin == 2.0 and r is not friction)
    assert all(friction.errors[n] > 1.3 * plain.errors[n] for n in plain.errors)


def test_the_proved_gains_alone_stand_beside_what_the_start_phase_makes_of_them(outcomes):
    """From the start on the filter all observers share does most of it; later the gains are on their own."""
    whole = next(r for r in outcomes if (r.window.begin, r.window.end) == (0.0, 2.0))
    late = next(r for r in outcomes if (r.window.begin, r.window.end) == (13.0, 15.0))
    assert set(whole.alone) == set(whole.errors) - {"ekf", "ukf"}
    assert all(whole.alone[n] > 4.0 * whole.errors[n] for n in whole.alone)
    assert all(late.alone[n] == pytest.approx(late.errors[n], rel=0.1) for n in late.alone)


def test_the_command_prints_and_writes(tmp_path, monkeypatch, car):
    monkeypatch.chdir(CONFIG.parent)
    csv, table, pictures = tmp_path / "a.csv", tmp_path / "a.json", tmp_path / "pictures"
    files = ["--json", str(table), "--csv", str(csv), "--pictures", str(pictures)]
    done = CliRunner().invoke(app, ["chapter_5_step", *files])
    assert done.exit_code == 0, done.output
    names = [e.name for e in estimators_of(car, CONFIG / "gains")]
    assert {"ekf", "ukf", "nlpv_polytopic"} <= set(names)
    found = json.loads(table.read_text())
    assert found["windows"][0]["published"]["unified"] == 0.0212
    assert set(found["windows"][0]["nrmse"]) == set(names)
    assert f"{100 * found['windows'][0]['nrmse']['ekf']:.2f}" in done.output
    assert (
        "microseconds" not in done.output
    )  # one run of many at once says nothing of them: `er bench observers`
    assert len(csv.read_text().splitlines()) == 1 + len(names)
    assert (pictures / "chapter_5_step.png").stat().st_size > 10_000


@pytest.mark.parametrize("name", OBSERVERS)
def test_every_observer_is_compared(car, name):
    """The steps of CONTRIBUTING.md: its gains are where the comparison looks for them."""
    assert name in [e.name for e in estimators_of(car, CONFIG / "gains") if e.ours]
