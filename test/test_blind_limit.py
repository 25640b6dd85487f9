"""What nobody can promise on fresh data: another damper that the record hardly tells from the hidden one."""

import json
from dataclasses import replace

import numpy as np
import pytest

from test.blind.generator import make_case, more_records
from test.blind_score import limit
from test.blind_score.limit import BENT, FORMS, forces, rival, true_motion

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    out = tmp_path_factory.mktemp("limit") / "case"
    return make_case("self_heating", 58, out=out, n_records=1, seconds=10.0, target=0.6)


def distance(damper, case):
    rig = true_motion(case)
    return np.linalg.norm(forces(damper, rig) - forces(case, rig)) / case.noise.force


def test_the_rig_imposes_the_motion_of_the_car(case):
    """The force along it is that in the car."""
    found, force = forces(case, true_motion(case)), case.clean[0]["damper_force"]
    assert np.abs(found - force).max() < 2e-3 * np.abs(force).max()


def test_the_nearest_damper_of_another_form_is_nearer_than_the_same_values(case):
    (one,) = case.hidden
    row = one.row.copy()
    row[BENT] = FORMS["line"]
    bent = replace(case, hidden=(replace(one, row=row),))
    near = rival(case, FORMS["line"])
    assert 0.0 < near.distance < 0.5 * distance(bent, case)
    assert near.distance == pytest.approx(distance(near.case, case), rel=1e-6)
    assert near.case.hidden[0].row[BENT] == FORMS["line"]


def test_a_known_car_tells_more_than_the_force(case):
    """Its accelerometers weigh the force by the masses."""
    assert (
        rival(case, FORMS["line"], car=True).distance > 2.0 * rival(case, FORMS["line"]).distance
    )


def test_its_own_form_is_no_other_damper(case):
    same = rival(case, 0.0)
    assert same.distance == pytest.approx(0.0, abs=1e-6)
    assert same.mistaken == pytest.approx(0.5)


def test_the_probability_is_that_of_a_normal_tail(case):
    near = replace(rival(case, 0.0), distance=2.0)
    assert near.mistaken == pytest.approx(0.158655, abs=1e-6)


def test_all_forms_are_one_family(case, tmp_path):
    """The exponential lies between hyperbola and line, along any motion."""
    (one,) = case.hidden
    fresh = true_motion(more_records(case, 9, out=tmp_path / "fresh", n_records=1))

    def along(bend):
        row = one.row.copy()
        row[BENT] = bend
        return forces(replace(case, hidden=(replace(one, row=row),)), fresh)

    curve, middle, line = (along(bend) for bend in (0.0, FORMS["exponential"], FORMS["line"]))
    near = along(FORMS["exponential"] + 1e-5)
    assert np.abs(near - middle).max() < 1e-3 * np.abs(middle).max()
    gaps = [np.linalg.norm(other - curve) for other in (middle, line)]
    assert 0.0 < gaps[0] < gaps[1]


def test_the_command_notes_and_tables_what_it_finds(tmp_path, capsys):
    """As `docs/results/blind.md` has it, `exec python -m test.blind_score.limit`, with a shorter record."""
    noted = tmp_path / "rows.jsonl"
    words = ["--seeds", "58", "--workers", "1", "--seconds", "10", "--results", str(noted)]
    assert limit.main(words) == 0
    (row,) = (json.loads(line) for line in noted.read_text().splitlines())
    assert set(row["forms"]) == set(FORMS)
    for found in row["forms"].values():
        assert 0.0 < found["mistaken"] < 0.5
        assert found["ratio"] == pytest.approx(np.hypot(1.0, 0.5 * found["gap"] / row["truth"]))
    text = capsys.readouterr().out
    assert "least ratio for one of the two" in text
    assert "| 58 | line |" in text
