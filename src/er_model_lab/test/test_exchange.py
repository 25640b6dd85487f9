"""Effects of several passes exchanged for what came near them in their rounds."""

from __future__ import annotations

import pytest
from er_model_lab.diagnosis import exchange
from er_model_lab.diagnosis.candidates import Candidate, baseline, refit
from er_model_lab.diagnosis.exchange import exchanged_late
from er_model_lab.diagnosis.null import simulate_null
from er_model_lab.diagnosis.search import Round
from er_model_lab.problem.problem import Problem
from lab_help import problem_of

TRUE, WRONG = "coulomb_friction", "quadratic_damping"
Case = tuple[Problem, Round, dict[str, Candidate]]


@pytest.fixture(scope="module")
def case() -> Case:
    """A round of a damper with Coulomb friction, in which something else was taken."""
    model, problem = problem_of(TRUE, {"F_c": 3.0, "v_0": 0.003}, seconds=12.0)
    base = baseline(model, problem)
    found = {name: refit(base, model.catalogue[name], problem) for name in (TRUE, WRONG)}
    null = simulate_null(base, [], problem, 1)
    return problem, Round(base, [*found.values()], null, 0.01, found[WRONG], [WRONG]), found


def test_what_leaves_less_comes_in_the_place_of_what_was_taken(case: Case) -> None:
    problem, step, found = case
    best, made = exchanged_late(found[WRONG], [step], problem, step.threshold)
    assert made == ((WRONG, TRUE),)
    assert best.effects == (TRUE,)
    assert WRONG not in best.fit.model.effects
    assert best.left == pytest.approx(found[TRUE].left, rel=0.01)


def test_what_leaves_more_does_not(case: Case) -> None:
    problem, step, found = case
    other = Round(step.base, step.candidates, step.null, step.threshold, found[TRUE], [TRUE])
    assert exchanged_late(found[TRUE], [other], problem, 0.0) == (found[TRUE], ())


def test_held_out_data_and_a_gain_that_does_not_count_keep_what_was_taken(
    case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, step, found = case
    assert exchanged_late(found[WRONG], [step], problem, 1e3)[1] == ()
    monkeypatch.setattr(exchange, "rises", lambda *_: True)
    assert exchanged_late(found[WRONG], [step], problem, step.threshold)[1] == ()


def test_what_came_near_an_effect_may_replace_it_and_those_taken_later(
    case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, step, _ = case
    monkeypatch.setattr(exchange, "close", lambda s: [TRUE, WRONG] if s is step else [])
    later = Round(step.base, [], step.null, 1.0, None, [])
    model = step.base.fit.model.with_effect(WRONG)
    found = exchange._pairs({"before": later, WRONG: step, "later": later}, model)
    assert list(found) == [(WRONG, TRUE), ("later", TRUE)]
    assert found["later", TRUE] == step.candidates[0].fit.model.effects[TRUE]
