"""A refinement that does another effect's work is not taken for what it is called."""

import pytest
from er_model_lab.diagnosis.candidates import baseline, effect_size, refit, without
from er_model_lab.diagnosis.null import simulate_null
from er_model_lab.diagnosis.refinements import makes_up, refined, stands_in
from er_model_lab.diagnosis.rule import RULE
from er_model_lab.diagnosis.search import decided, prune
from lab_help import problem_of

BRAKE = {"F_h": 6.0, "F_u": 0.0, "z_y": 3e-4, "b": 3e-4}
LIMIT, SMALL = 0.5, 0.1
PRELOAD = 3.0


def _tried(g, preload):
    """The candidates beside a model that lacks a friction with play, which grips harder one way, and a preload [N]."""
    hidden = BRAKE | {"g": g}
    model, problem = problem_of(
        "friction_with_play", hidden, seconds=12.0, bent=lambda f, x: f + preload
    )
    base = baseline(model, problem)
    names = ("friction_with_play", "preload")
    friction, offset = (refit(base, model.catalogue[n], problem, max_iter=20) for n in names)
    assert friction.left < offset.left
    return base, [friction, offset], problem


def test_a_preload_that_passes_for_a_friction_that_grips_harder_one_way_is_taken_first():
    base, tried, problem = _tried(g=0.0, preload=PRELOAD)
    assert ("friction_with_play", "g") in refined(tried[0], problem)
    assert stands_in(base, tried[0], tried, problem, LIMIT)
    step = decided(base, tried, simulate_null(base, tried, problem, 0), problem, RULE)
    assert step.taken is not None
    assert step.taken.name == "preload"


def test_a_friction_that_grips_harder_one_way_stays_what_it_is():
    base, tried, problem = _tried(g=0.5, preload=0.0)
    assert ("friction_with_play", "g") in refined(tried[0], problem)
    assert not stands_in(base, tried[0], tried, problem, LIMIT)


def test_an_effect_without_a_refinement_has_none_in_use():
    _, (_, offset), problem = _tried(g=0.0, preload=PRELOAD)
    assert refined(offset, problem) == []


@pytest.mark.parametrize(("g", "preload", "stays"), [(0.0, PRELOAD, True), (0.5, 0.0, False)])
def test_a_preload_stays_where_only_a_refinement_would_make_up_for_it(g, preload, stays):
    base, tried, problem = _tried(g=g, preload=preload)
    both = refit(tried[0], base.fit.model.catalogue["preload"], problem, max_iter=20)
    less = without("preload", problem, both)
    limit = max(1.2 * effect_size(less, both), SMALL)
    assert makes_up(both, less, problem, limit) is stays
    assert ("preload" in prune(both, problem, limit).effects) is stays
