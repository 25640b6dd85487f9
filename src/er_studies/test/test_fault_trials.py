"""How the fault estimator is judged on a drive: what happened, and what any estimator could have known."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from er_models.errors import InputError
from er_models.model import Model
from er_observers.faults import regression
from er_observers.faults.rules import estimator
from er_observers.faults.sample import Kind
from er_studies.faults import bound, command, statistics_command
from er_studies.faults.acceptance import Outcome, Quiet, faultless, faulty
from er_studies.faults.statistics import (
    CLOSE,
    GROUPS,
    IN_TIME,
    Found,
    found_in,
    plain,
    read,
    trial_of,
)
from er_studies.faults.trials import COURSES, Trial, drive


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


def test_the_command_tells_what_was_found_and_what_was_not_noticed(
    tmp_path, monkeypatch, capsys
) -> None:
    """Two drives of each fault and two of each hidden effect, judged as given."""
    known = Outcome(
        {"f1": 0.5}, {"f1": 0.2}, (1.0, 0.5, 0.9), Kind.NONE, math.inf, False, False, True
    )
    noticed = {"coulomb_friction": (("LEAKAGE",), ("LEAKAGE",), True), "preload": ((), (), True)}

    def quiet(_p, _trial, _model, name=""):
        named, silent, doubted = noticed.get(name, ((), (), False))
        return Quiet(name, named, silent, doubted, (True, True, False))

    monkeypatch.setattr(command, "faulty", lambda *_: known)
    monkeypatch.setattr(command, "faultless", quiet)
    command.fault_trials_command(number=20, seed=5, json_file=tmp_path / "tables.json")
    faults, none, hidden = json.loads((tmp_path / "tables.json").read_text())["tables"]
    row = ["f1", "0/20", "0/0", "100 %", "50 %", "0/20", "90 %", "0", "0", "never", "0", "20"]
    assert [r[0] for r in faults["rows"]] == ["f1", "f2", "f3", "combined"]
    assert faults["rows"][0] == row
    assert faults["title"] == "20 drives each, seed 5, parameters within 0 %"
    assert none["rows"][0][1] == "0 of 40 with a fault, 0 unexplained"
    assert none["rows"][1] == ["standstill", "not excited: f1, f2"]
    assert {tuple(r) for r in hidden["rows"]} == {
        ("coulomb_friction", "2", "2", "2 (leakage)"),
        ("preload", "2", "0", "0"),
    }
    assert "| f1 | 0/20 | 0/0 |" in capsys.readouterr().out


SEED = 4711
"""Of drives that nothing was tuned on."""


@pytest.mark.parametrize("number", [*range(0, 14, 2), 13])
def test_no_road_makes_a_healthy_damper_faulty(car: Model, number: int) -> None:
    group = replace(GROUPS[0], seconds=20.0)
    trial = trial_of(group, SEED, number)
    assert trial.road in COURSES
    found = found_in(trial, car, estimator(car))
    assert (found.wrong, found.last, found.unexplained) == ((), "NONE", 0.0)


@pytest.mark.parametrize("name", ["friction 0.5 N", "mass +20 %"])
def test_what_is_no_fault_is_not_named_one(car: Model, name: str) -> None:
    (group,) = (replace(g, seconds=20.0) for g in GROUPS if g.name == name)
    for number in (1, 8):
        assert found_in(trial_of(group, SEED, number), car, estimator(car)).wrong == ()


@pytest.mark.parametrize("name", ["f1 = 0.5", "f2 = 0.6", "f3 = 0.6"])
def test_a_fault_is_named_and_measured_on_roads_of_every_class(car: Model, name: str) -> None:
    (group,) = (g for g in GROUPS if g.name == name)
    for number in (0, 2, 4):
        found = found_in(trial_of(group, SEED, number), car, estimator(car))
        assert found.named <= IN_TIME
        assert found.error <= CLOSE
        assert (found.wrong, found.doubted) == ((), False)


def test_statistics_go_on_with_the_drives_that_a_file_holds(tmp_path, monkeypatch, capsys) -> None:
    """A drive that never got its name has no time in JSON, and what is known is not driven again."""
    asked, file = [], tmp_path / "drives.json"
    group = next(g for g in GROUPS if g.left)
    found = Found("chirp", (), 0.0, math.inf, 0.5, 0.01, 12.0, "NONE", False, False, 1.0)
    late = found._replace(moved_before=3.0)

    def driven(groups, model, seed, number, known):
        asked.append(known)
        return [
            (g, late if k else found) for g in groups for k in range(known.get(g.name, 0), number)
        ]

    monkeypatch.setattr(statistics_command, "statistics", driven)
    for number in (2, 3):
        statistics_command.fault_statistics_command([group.name], number=number, json_file=file)
    assert asked == [{group.name: 0}, {group.name: 2}]
    drives = read(json.loads(file.read_text())["drives"])
    first, *later = drives[group.name]
    assert (first, later) == (found._replace(wrong=[]), [late._replace(wrong=[])] * 2)
    assert "Infinity" not in json.dumps(plain(drives))
    (told,) = statistics_command.tables(drives)
    head, rows = told.head, told.rows
    assert json.loads(file.read_text())["tables"] == [
        {"head": head, "rows": rows, "title": "seed 1"}
    ]
    assert [row[:3] for row in rows] == [
        [group.name, "all", "3"], ["", "all that moved 3 s before", "2"], ["", "chirp", "3"],
    ]  # fmt: skip
    assert rows[0][head.index("median s to name")] == "never"
    with pytest.raises(InputError, match="drives of seed 2"):
        statistics_command.fault_statistics_command([group.name], seed=2, json_file=file)
