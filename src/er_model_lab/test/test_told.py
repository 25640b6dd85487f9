"""Each effect is told by the round that decided on it, in the result and on its card."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline, effect_size, refit
from er_model_lab.diagnosis.investigation import judge
from er_model_lab.diagnosis.noise_floor import Floor
from er_model_lab.diagnosis.null import Null
from er_model_lab.diagnosis.search import Round
from er_model_lab.level.study import Study
from er_model_lab.output.text.ranking import limit
from er_model_lab.results.diagnosis import diagnosis_json
from er_model_lab.results.draw import candidate_views
from er_model_lab.results.steps import errors_of, steps
from lab_help import asked, problem_of

NAMES = ("field_exponent", "coulomb_friction", "preload")
FIRST, LATER = 0.3, 0.1
"""Sizes [N] that chance reaches in the first and in the second round."""


@pytest.fixture(scope="module")
def search():
    """The model, each effect alone, the two hidden ones together, and their problem."""
    model, problem = problem_of("coulomb_friction", {"F_c": 0.9, "v_0": 0.003}, seed=2)
    hidden = model.with_effect("field_exponent", {"b": 1.4, "u_r": 0.3})
    problem = replace(
        problem, force=problem.force + problem.predict(hidden) - problem.predict(model)
    )
    base = baseline(model, problem)
    alone = [refit(base, model.catalogue[name], problem) for name in NAMES]
    both = refit(alone[0], model.catalogue[NAMES[1]], problem)
    return model, problem, base, alone, both


def round_of(base, candidates, taken, limit, ties=()):
    sizes = np.full(64, limit / 4.0) + np.linspace(0.0, 0.01, 64)
    return Round(
        base, candidates, Null(sizes, 0.0, 1.0, 0.0, np.zeros(0)), limit, taken, list(ties)
    )


def result_of(search, best, rounds, ties=()):
    """Entries of the result by name, and the cards."""
    model, problem, base, *_ = search
    floor = Floor(0.99 * np.sqrt(best.mse), 0.0, 0.0, 0.0, 0.0, {}, (0.0, 0.0, 0.0))
    found = judge(base, best, rounds, floor, problem, ties)
    study = Study(asked(model, problem), found)
    result = diagnosis_json(study, found.model)
    cards = {card.effect: card for card in candidate_views(study, result)}
    return {e["effect"]: e for e in result["candidates"]}, cards, result


def second(search, ties=()):
    """Both rounds of a search that took the two effects one after the other."""
    model, problem, base, alone, both = search
    rest = refit(alone[0], model.catalogue["preload"], problem)
    return [
        round_of(base, alone, alone[0], FIRST),
        round_of(alone[0], [both, rest], both, LATER, ties),
    ]


def test_an_effect_that_a_later_round_took_has_the_numbers_of_that_round(search):
    *_, alone, both = search
    entries, cards, result = result_of(search, both, second(search))
    friction, step = entries["coulomb_friction"], result["steps"][2]
    assert step["added"] == "coulomb_friction"
    for key in ("evidence", "threshold", "rmse_held_out"):
        assert friction[key] == step[key]
    assert friction["evidence"] == effect_size(alone[0], both) > 3.0 * LATER
    assert friction["p_value"] < 1e-3
    assert friction["rmse_before"] == entries["field_exponent"]["rmse_held_out"]
    assert friction["parameters"]["F_c"][0] == both.fit.model.value("coulomb_friction", "F_c")
    assert (entries["field_exponent"]["threshold"], entries["preload"]["threshold"]) == (
        FIRST,
        FIRST,
    )
    assert cards["coulomb_friction"].entry is friction
    assert f"chance reaches {LATER} N" in cards["coulomb_friction"].reason
    np.testing.assert_array_equal(
        np.unique(cards["coulomb_friction"].residual_y),
        np.unique(cards["field_exponent"].residual_y - cards["field_exponent"].signature_y),
    )


def test_what_a_later_round_ties_has_the_numbers_of_that_round(search):
    ties = ("coulomb_friction", "preload")
    entries, _, _ = result_of(search, search[-1], second(search, ties), (ties,))
    assert [entries[name]["threshold"] for name in NAMES] == [FIRST, LATER, LATER]
    assert [entries[name]["status"] for name in NAMES] == ["present", "confounded", "confounded"]


def test_what_took_the_place_of_another_has_the_numbers_of_that_round(search):
    model, problem, base, alone, both = search
    other = refit(alone[0], model.catalogue["stribeck_friction"], problem)
    rounds = [round_of(base, alone, alone[0], FIRST),
              round_of(alone[0], [other, both], other, LATER, ("stribeck_friction", "coulomb_friction"))]  # fmt: skip
    entries, _, _ = result_of(search, both, rounds)
    assert entries["coulomb_friction"]["threshold"] == LATER
    assert entries["coulomb_friction"]["evidence"] == effect_size(alone[0], both)


def test_what_helps_and_is_not_taken_is_told_with_what_explains_the_error_better(search):
    _, _, base, alone, _ = search
    for taken, better in ((alone[0], [NAMES[0]]), (None, [])):
        best = alone[0] if taken else base
        entries, cards, _ = result_of(search, best, [round_of(base, alone, taken, 0.01)])
        friction = entries["coulomb_friction"]
        assert friction["evidence"] > 0.01
        assert (friction["status"], friction["explained_by"]) == ("absent", better)
        said = "Field exponent explains the error better" if taken else "too little to be named"
        assert said in cards["coulomb_friction"].reason
        assert entries["preload"]["explained_by"] == []


def test_what_was_exchanged_is_explained_better_by_what_took_its_place(search):
    """It was told as explained better by itself."""
    model, problem, base, alone, _ = search
    other = refit(base, model.catalogue["stribeck_friction"], problem)
    entries, _, _ = result_of(search, other, [round_of(base, [*alone, other], alone[0], 0.01)])
    assert entries[NAMES[0]]["explained_by"] == ["stribeck_friction"]


def test_an_effect_of_a_pair_has_what_it_adds_to_the_other_one(search):
    """No round took either: alone they may gain nothing at all."""
    _, _, base, alone, both = search
    entries, cards, _ = result_of(search, both, [round_of(base, alone, None, FIRST)])
    for name, other in ((NAMES[0], alone[1]), (NAMES[1], alone[0])):
        assert entries[name]["evidence"] == effect_size(other, both) > FIRST
        assert entries[name]["p_value"] < 1e-3
        assert entries[name]["status"] == "present"
        assert entries[name]["kept_fraction"] < 1.0
        assert cards[name].reason.startswith("taken: lowers")
    entries, _, _ = result_of(search, both, [round_of(base, alone, alone[0], FIRST)])
    assert entries[NAMES[0]]["evidence"] == effect_size(base, alone[0])
    assert entries[NAMES[1]]["evidence"] == effect_size(alone[0], both)


def test_what_no_round_took_in_the_place_of_a_third_has_what_it_adds_to_all_others(search):
    """It was told with what it gained alone in the first round, which may be nothing."""
    model, problem, base, alone, _ = search
    third = refit(alone[0], model.catalogue["preload"], problem)
    best = refit(third, model.catalogue["coulomb_friction"], problem)
    idle = replace(alone[1], mse=base.mse + 1.0)
    rounds = [
        round_of(base, [alone[0], idle, alone[2]], alone[0], FIRST),
        round_of(alone[0], [third], third, LATER),
    ]
    entries, cards, result = result_of(search, best, rounds)
    said = entries["coulomb_friction"]
    assert said["evidence"] == effect_size(third, best)
    assert (said["status"], said["threshold"]) == ("present", LATER)
    assert cards["coulomb_friction"].reason.startswith("taken: lowers")
    (step,) = (s for s in result["steps"] if s["added"] == "coulomb_friction")
    assert step["evidence"] == said["evidence"]


def test_what_chance_reaches_in_the_first_round_is_told_by_an_effect_that_was_not_taken():
    candidates = [{"effect": name, "evidence": 0.4} for name in NAMES[:2]]
    for entry, chance in zip(candidates, (LATER, FIRST), strict=True):
        entry["threshold"] = chance
    view = SimpleNamespace(result={"effects": [NAMES[0]], "candidates": candidates})
    assert limit(view) == FIRST


def test_what_is_left_of_a_model_stands_before_what_was_taken_beside_it(search):
    """The first round took something that was taken out again: its second effect was there before the third."""
    model, problem, base, alone, both = search
    floor = Floor(0.99 * np.sqrt(both.mse), 0.0, 0.0, 0.0, 0.0, {}, (0.0, 0.0, 0.0))
    rounds = [round_of(base, alone, alone[2], FIRST), second(search)[1]]
    told = steps(Study(asked(model, problem), judge(base, both, rounds, floor, problem, ())))
    assert [s["added"] for s in told] == [None, *NAMES[:2]]
    errors = [s["rmse_train"] for s in told]
    assert errors == sorted(errors, reverse=True)
    assert "evidence" not in told[1]
    assert "evidence" in told[2]


def test_the_steps_of_a_pass_are_told_on_the_data_of_a_later_one(search):
    """Of long data a later pass may have more stretches: one fall is of one data set."""
    model, problem, base, alone, both = search
    floor = Floor(0.99 * np.sqrt(both.mse), 0.0, 0.0, 0.0, 0.0, {}, (0.0, 0.0, 0.0))
    study = Study(asked(model, problem), judge(base, both, second(search), floor, problem, ()))
    other = replace(problem, held_out=problem.train)
    own, told = steps(study), steps(study, other)
    assert [s["added"] for s in told] == [s["added"] for s in own] == [None, *NAMES[:2]]
    for s, fitted in zip(told, (base.fit, alone[0].fit, both.fit), strict=True):
        left = other.force - other.predict(fitted.model)
        assert s["rmse_held_out"] == pytest.approx(np.sqrt(np.mean(left[other.held_out] ** 2)))
        assert s["rmse_held_out"] != own[told.index(s)]["rmse_held_out"]
    after = errors_of(study, other)
    assert after["rmse"]["held_out"] == pytest.approx(told[0]["rmse_held_out"])
    assert after["rmse_after"]["held_out"] == pytest.approx(told[-1]["rmse_held_out"])
    assert errors_of(study, problem)["rmse"] == pytest.approx(errors_of(study)["rmse"])
