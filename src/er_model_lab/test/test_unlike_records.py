"""Records whose force differs at the same motion by what no channel tells: said, and nothing is named for it."""

from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.diagnosis.ranking import TRYING
from er_model_lab.diagnosis.search import LEAVING_OUT
from er_model_lab.motion.unlike_records import Course, difference, unlike
from er_model_lab.preflight.between import between_findings
from er_models.files import load_model
from er_models.prediction import motion, predict
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import DT, FORCE_NOISE, GUO, imposed

import er_model_lab as lab

N = 1200


def records(changed=lambda k, u, force: force, effect=None, seed=1, duty=True, began=False):
    """Three records of one damper, of which one is changed."""
    rng, model = np.random.default_rng(seed), load_model(GUO)
    truth = model.with_effect(*effect) if effect else model
    made = []
    for k in range(3):
        x, v, a, u = imposed(rng, N)
        u = u if duty else np.full(N, (0.0, 0.3, 0.9)[k])
        force = changed(k, u, predict(truth, motion(DT, x, v, u, a)))
        channels = {
            "deflection": x + 2e-5 * rng.standard_normal(N), "deflection_velocity": v, "sprung_acceleration": a,
            "damper_force": force + FORCE_NOISE * rng.standard_normal(N), "unsprung_acceleration": 0.0 * a,
        }  # fmt: skip
        channels |= {"duty": u} if duty else {}
        made.append(Record(f"run{k}", np.arange(N) * DT, channels))
    return made


def courses(made):
    return [
        Course(r.name, r.channels["deflection"], r.channels["deflection_velocity"],
               r.channels.get("duty", np.zeros(N)), r.channels["damper_force"])
        for r in made
    ]  # fmt: skip


@pytest.mark.parametrize("effect", [
    None,
    ("coulomb_friction", {"F_c": 3.0, "v_0": 0.003}),
    ("bouc_wen_hysteresis", {"F_h": 4.0, "z_y": 1e-3}),
    ("self_heating", {}),
    ("gas_spring", {}),
])  # fmt: skip
def test_records_of_one_damper_are_alike(effect):
    made = records(effect=effect)
    assert unlike(courses(made)) is None
    assert list(between_findings(made)) == []


@pytest.mark.parametrize("shift", [100.0, -100.0])
def test_another_level_is_said_with_its_size(shift):
    made = records(lambda k, _, force: force + shift * (k == 1))
    found = unlike(courses(made))
    assert found.level == pytest.approx(100.0, rel=0.15)
    assert (found.name if shift > 0.0 else found.other) == "run1"
    (finding,) = between_findings(made)
    assert (finding.check, finding.level, finding.found) == ("records", "warning", str(found))


def test_what_stays_of_a_difference_is_measured_where_it_was_found():
    shifted = courses(records(lambda k, _, force: force + 100.0 * (k == 1)))
    even, wider = courses(records()), courses(records(duty=False))
    assert difference(unlike(shifted), shifted) == pytest.approx(100.0, rel=0.15)
    assert difference(unlike(shifted), even) < 10.0
    found = unlike(wider)
    assert difference(found, [replace(c, force=0.5 * c.force) for c in wider]) == pytest.approx(
        0.5 * difference(found, wider)
    )
    assert difference(found, wider) > 10.0 * difference(found, even)


def test_missing_samples_and_records_that_lack_all_do_not_count():
    made = courses(records(lambda k, _, force: force + 100.0 * (k == 1)))
    missing = np.where(np.arange(N) // 40 == 2, np.nan, 0.0)
    made[0] = replace(made[0], v=made[0].v + missing, force=made[0].force + np.roll(missing, 200))
    empty = Course("empty", *(np.full(50, np.nan) for _ in range(4)))
    assert unlike([*made, empty]).level == pytest.approx(100.0, rel=0.15)
    assert unlike([made[0], empty]) is None


def test_a_duty_that_nobody_recorded_is_another_width():
    found = unlike(courses(records(duty=False)))
    assert (found.name, found.other, found.level) == ("run2", "run0", 0.0)
    assert found.wider > 3.0


def test_one_direction_is_enough_where_the_other_was_driven_at_other_speeds():
    def course(name, fast, lift):
        t = DT * np.arange(N)
        extends = (t % 2.0) < 1.0
        v = np.where(extends, fast, -0.1)
        return Course(name, 0.01 * (t % 1.0), v, 0.0 * t, np.sign(v) * 5.0 + lift)

    assert unlike([course("a", 0.05, 0.0), course("b", 0.08, 0.0)]) is None
    found = unlike([course("a", 0.05, 0.0), course("b", 0.08, 60.0)])
    assert (found.name, found.level) == ("b", pytest.approx(60.0, rel=1e-6))


def test_a_model_is_not_complete_where_the_record_that_differs_only_scores():
    made = records(lambda k, _, force: force + 100.0 * (k == 1))
    data, model = Dataset.of([made[0], made[2]], [made[1]]), load_model(GUO)
    result = lab.diagnose(data, model, seed=1)
    assert (result.verdict, list(result.effects)) == ("insufficient_data", [])
    assert "force of run1 is 100 N above" in " ".join(result.to_dict()["reasons"])


def test_no_effect_is_named_or_added_for_it():
    model = load_model(GUO)
    data = Dataset.of(records(lambda k, _, force: force + 100.0 * (k == 1)))
    stages = set()
    result = lab.improve(data, model, seed=1, progress=lambda stage, *_: stages.add(stage))
    # no effect evens them out: none is looked for beside the first
    assert TRYING in stages
    assert LEAVING_OUT not in stages
    assert (result.verdict, list(result.effects)) == ("insufficient_data", [])
    assert "force of run1 is 100 N above" in result.to_dict()["coverage"]["unlike"]
    assert result.to_dict()["coverage"]["unlike"] in result.to_dict()["reasons"]
    assert result.model.effects == model.effects
    other = lab.diagnose(
        Dataset.of(records(effect=("coulomb_friction", {"F_c": 3.0, "v_0": 0.003}))), model, seed=1
    )
    assert (other.verdict, list(other.effects)) == ("missing_effect", ["coulomb_friction"])
