"""Scenario files say what is driven, and the drive does it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from er_models.errors import ErError, InputError
from er_models.linear import relative_form
from er_studies.observers.kalman import Statement
from er_studies.observers.scenarios.drive import drive
from er_studies.observers.scenarios.files import choose_scenarios, load_scenario, load_scenarios
from er_studies.observers.scenarios.starts import first_state

FOLDER = Path(__file__).resolve().parents[3] / "config" / "scenarios"
DT = 0.005


@pytest.fixture(scope="module")
def scenarios():
    return {s.name: s for s in load_scenarios(FOLDER)}


def test_every_published_figure_stands_in_a_file(scenarios):
    """Tables 3.1, 4.1, 5.2-5.6 and the simulations of 3.5, as printed; order: polytopic, gridding, unified."""
    printed = {
        "3.5.1": (None, None, 0.012), "3.5.2": (None, None, 0.009), "3.5.3": (None, None, 0.0258),
        "5.2": (0.0767, 0.1023, 0.0212), "5.3": (0.0262, 0.0277, 0.0142),
        "5.4": (0.0712, 0.0756, 0.0386), "5.5": (0.0148, 0.0081, 0.0057),
        "5.6": (0.0763, 0.0745, 0.0563),
    }  # fmt: skip
    found = {w.table: w for s in scenarios.values() for w in s.windows if w.table}
    for table, figures in printed.items():
        names = ("nlpv_polytopic", "nlpv_gridding", "unified")
        assert tuple(found[table].published.get(n) for n in names) == figures
    rig = [scenarios[f"experiment_{road}"].windows[0].published for road in ("bumps", "iso")]
    assert [p["unified"] for p in rig] == [0.0440, 0.0547]
    assert [p["nlpv_polytopic"] for p in rig] == [0.0481, 0.0763]
    assert [p["nlpv_gridding"] for p in rig] == [0.0416, 0.0708]


def test_a_drive_is_seeded_and_its_sensors_are_as_stated(car, scenarios):
    s = replace(scenarios["wrong_sensors_bias"], skyhook=None)
    s = replace(s, program=replace(s.program, duration=4.0))
    s = replace(s, sensors=replace(s.sensors, delay=0.01))
    one, again, other = drive(s, car, 0), drive(s, car, 0), drive(s, car, 1)
    assert all(np.array_equal(one[k], again[k], equal_nan=True) for k in one)
    assert not np.allclose(one["road"], other["road"])
    for name, sign in (("sprung_acceleration", 1.0), ("unsprung_acceleration", -1.0)):
        rest = one[f"told_{name}"][2:] - one[name][:-2]
        assert rest.mean() == pytest.approx(sign * 0.05, abs=0.004)
        assert rest.std() == pytest.approx(0.025, rel=0.1)
    assert np.abs(one["deflection_velocity"]).max() == pytest.approx(0.15, rel=2e-3)


def test_skyhook_switches_on_the_true_velocities(car, scenarios):
    s = scenarios["chapter_5_noise"]
    record = drive(replace(s, program=replace(s.program, duration=2.0)), car)
    sprung = np.concatenate([[0.0], np.cumsum(DT * 0.5 * (
        record["sprung_acceleration"][1:] + record["sprung_acceleration"][:-1]
    ))])  # fmt: skip
    clear = np.abs(sprung) > 5e-3
    wanted = np.where(sprung * record["deflection_velocity"] >= 0.0, 0.3, 0.0)
    assert np.array_equal(record["duty"][clear], wanted[clear])
    assert 0.2 < np.mean(record["duty"] > 0.0) < 0.8
    assert np.array_equal(record["duty"], record["told_duty"])


def test_the_plant_is_as_wrong_as_the_file_says(car, scenarios):
    s = scenarios["wrong_duty_quantised"]
    record = drive(replace(s, program=replace(s.program, duration=2.0)), car)
    assert np.allclose(record["duty"] / 0.02, np.round(record["duty"] / 0.02), atol=1e-9)
    assert 0.002 < np.abs(record["duty"] - record["told_duty"]).max() <= 0.0100001
    short = {n: replace(s, program=replace(s.program, duration=0.2)) for n, s in scenarios.items()}
    plain = drive(replace(short["wrong_parameters"], plant=replace(s.plant)), car)
    for name in ("wrong_parameters", "hidden_effects/dead_time", "experiment_iso"):
        same = replace(short[name], program=short["wrong_parameters"].program)
        assert not np.allclose(drive(same, car)["damper_force"], plain["damper_force"])


def test_the_initial_errors_are_those_of_the_thesis(car, scenarios):
    """Fact 5 of the notes: the unified observer of the thesis starts only 1.05 mm wrong."""
    form = relative_form(car)
    rest = dict.fromkeys(("deflection", "deflection_velocity", "tyre_deflection"), np.zeros(1))
    thesis, equal = scenarios["chapter_5_noise"], scenarios["chapter_5_noise_equal"]
    unified = first_state(thesis, form, "unified", rest)
    assert unified[0] == pytest.approx(-1.05e-3, abs=5e-6)
    assert first_state(thesis, form, "nlpv_gridding", rest) == pytest.approx([0.01, 0, 0.001, 5])
    assert first_state(equal, form, "unified", rest) == pytest.approx([0.01, 0, 0.001, 5])
    assert first_state(scenarios["experiment_iso"], form, "unified", rest) is None


def test_drawn_starts_have_the_covariance_that_the_filters_are_told(car, scenarios):
    """The same for every observer, another one for each road, and as wide as stated."""
    form, drawn = relative_form(car), scenarios["chapter_4_step_drawn"]
    rest = dict.fromkeys(("deflection", "deflection_velocity", "tyre_deflection"), np.ones(1))
    starts = np.array([first_state(drawn, form, "unified", rest, k) for k in range(400)])
    assert first_state(drawn, form, "ekf", rest, 3) == pytest.approx(starts[3])
    assert starts.mean(axis=0) == pytest.approx([1, 1, 1, 0], abs=0.8)
    assert starts.std(axis=0) == pytest.approx(Statement().spread, rel=0.12)


BAD = [
    ({"start": "wrong"}, "start"),
    ({"windows": []}, "windows"),
    ({"windows": [{"begin": 3.0, "end": 99.0}]}, "windows[0]"),
    ({"windows": [{"begin": 0.0, "end": 1.0, "published": {"kalman": 0.1}}]}, "published.kalman"),
    ({"program": {"road": {"kind": "flat"}, "duty": {"kind": "constant"}, "duration": 0}}, "duration"),
    ({"skyhook": {"low": 0.0}}, "skyhook.high"),
    ({"sensors": {"duty_step": 0.1}}, "sensors.duty_step"),
    ({"plant": {"effects": {"friction": {}}}}, "friction"),
    ({"plant": {"effects": {"dead_time": {"F_c": 1.0}}}}, "dead_time.F_c"),
    ({"variants": {}}, "variants"),
    ({"color": 1}, "color"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "named"), BAD, ids=[b[1] for b in BAD])
def test_a_bad_file_is_one_line(tmp_path, change, named):
    document = yaml.safe_load((FOLDER / "chapter_5_noise.yaml").read_text())
    path = tmp_path / "bad.yaml"
    path.write_text(yaml.safe_dump({**document, **change}))
    with pytest.raises(ErError) as error:
        load_scenario(path)
    assert named in str(error.value)
    assert "\n" not in str(error.value)


def test_scenarios_are_chosen_by_name_or_file(tmp_path, scenarios):
    every = tuple(scenarios.values())
    assert len(choose_scenarios(every, ["hidden_effects"])) > 5
    assert [s.name for s in choose_scenarios(every, ["chapter_5_step"])] == ["chapter_5_step"]
    with pytest.raises(ErError, match="did you mean chapter_5_noise"):
        choose_scenarios(every, ["chapter_5_nose"])
    with pytest.raises(InputError):
        load_scenarios(tmp_path)
