"""A fit looks for its way in longer steps and ends in the usual ones; a search goes on where the last one ended."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from er_model_lab.diagnosis import candidates, investigation
from er_model_lab.diagnosis.candidates import baseline, refit
from er_model_lab.diagnosis.investigation import search_effects
from er_model_lab.diagnosis.search import afresh, one_round
from er_model_lab.fitting import fit as fitting
from er_model_lab.fitting.fit import AWAY, Box, _jacobian, fit, part_of
from er_model_lab.level import damper
from er_model_lab.level.damper import DamperLevel
from er_model_lab.problem import forward
from er_model_lab.problem.forward import COARSE, DamperForward
from er_model_lab.problem.problem import Practice, Problem
from lab_help import problem_of

FRICTION = {"F_c": 1.0, "v_0": 0.003}


@pytest.fixture(scope="module")
def sought():
    """A model that lacks friction, and its problem."""
    return problem_of("coulomb_friction", FRICTION, seconds=12.0)


def test_longer_steps_are_exact_at_the_model_and_its_derivatives_are_theirs(sought):
    model, problem = sought
    here = problem.predict(model)
    near = problem.near(model, here)
    assert near.forward.longest == COARSE
    np.testing.assert_allclose(near.predict(model), here, atol=1e-12)
    box = Box(model, problem.forward.free(model), problem.scales)
    usual, longer = (_jacobian(box, box.start(), here, p, None) for p in (problem, near))
    assert 0.0 < np.linalg.norm(usual - longer) < 0.02 * np.linalg.norm(usual)


@pytest.mark.parametrize("effect", ["freeplay", "mount_compliance"])
def test_a_fit_leaves_a_damper_behind_a_gap_some_damping(sought, effect):
    """Without any it would cross its gap at any speed: it was predicted with 10 MN."""
    model, problem = sought
    bare = model.with_effect("passive", {**model.effects["passive"], "c0": 0.0}).with_effect(
        effect
    )
    box = Box(bare, problem.forward.free(bare), problem.scales)
    k = box.free.index(("passive", "c0"))
    least = 1e-3 if effect == "freeplay" else 0.0
    assert (box.low[k], box.start()[k]) == (least, least)
    force = problem.predict(box.model_at(box.start()))
    assert np.std(force) < 2.0 * np.std(problem.force)


def test_a_sketch_takes_the_derivatives_of_what_it_adds_anew_and_no_others(sought, monkeypatch):
    """Those of a whole model, at each step of each start of each effect, were most of the work of a late round."""
    model, problem = sought
    base = fit(model, problem)
    grown = base.model.with_effect("coulomb_friction", {"F_c": 3.0, "v_0": 0.03})
    asked = list[int]()
    through = fitting._jacobian

    def counted(box, theta, f, where, known):
        asked.append(theta.size - (0 if known is None else known.shape[1]))
        return through(box, theta, f, where, known)

    monkeypatch.setattr(fitting, "_jacobian", counted)
    whole = fit(grown, problem, known=base.jacobian, max_iter=8)
    usual, asked = sum(asked), []
    drawn = fit(grown, problem, known=base.jacobian, max_iter=8, sketch=True)
    assert sum(asked) < 0.2 * usual
    assert asked == [3] * len(asked), "the numbers of the friction"
    assert len(asked) > 1
    assert drawn.mse(problem.train) < 1.02 * whole.mse(problem.train)


def test_a_row_that_jumps_tells_no_derivative(sought, monkeypatch):
    """At a sample another branch is as good as the one taken: 4 N over a step of a millionth are no slope."""
    model, problem = sought
    here, box = problem.predict(model), Box(model, problem.forward.free(model), problem.scales)
    smooth = _jacobian(box, box.start(), here, problem, None)
    through = DamperForward.predict_many

    def jumping(self, data, model, vectors):
        rows = through(self, data, model, vectors)
        rows[:, 700] += 4.0 * (vectors != model.compiled().p).any(axis=1)
        return rows

    monkeypatch.setattr(DamperForward, "predict_many", jumping)
    found = _jacobian(box, box.start(), here, problem, None)
    others = np.arange(here.size) != 700
    np.testing.assert_array_equal(found[others], smooth[others])
    np.testing.assert_array_equal(found[700], 0.0)


def test_a_step_that_a_fit_takes_is_looked_at_once(monkeypatch):
    """Where what is caught begins is found for the step, and known for the derivatives there."""
    hidden = {"F_h": 2.0, "z_y": 1e-4, "b": 3e-4}
    model, problem = problem_of("friction_with_play", hidden, seconds=8.0)
    grown = model.with_effect("friction_with_play", {name: 0.7 * v for name, v in hidden.items()})
    rows, there = problem.predicted(grown)
    np.testing.assert_array_equal(rows, problem.predict(grown))
    assert np.isfinite(there.forward.caught).any()
    np.testing.assert_allclose(there.predict(grown), rows, atol=1e-9)
    assert there.predicted(grown)[1] is there
    assert problem.predicted(model)[1] is problem
    monkeypatch.setattr(DamperForward, "near", lambda self, *_: self)
    looks, found = [], []
    look, many = forward.caught, forward.predict_many

    def looked(model, motion, told, **more):
        looks.append(told.caught is None)
        return look(model, motion, told, **more)

    def predicted(model, vectors, motion, told, **more):
        looks.append(len(vectors) * (told.caught is None))
        return many(model, vectors, motion, told, **more)

    monkeypatch.setattr(forward, "caught", looked)
    monkeypatch.setattr(forward, "predict_many", predicted)
    for again in (False, True):
        if again:  # as if nothing were known of a step
            monkeypatch.setattr(Problem, "predicted", lambda self, m: (self.predict(m), self))
        looks.clear()
        found.append((fit(grown, problem, max_iter=3), sum(looks)))
    (one, few), (other, more) = found
    np.testing.assert_array_equal(one.residual, other.residual)
    assert one.iterations > 1
    assert few < more


@pytest.mark.parametrize("share", [1.0, 0.5], ids=["as they are", "misleading"])
def test_a_fit_ends_where_the_usual_steps_would_have_led_it(sought, monkeypatch, share):
    model, problem = sought
    grown = model.with_effect("coulomb_friction", FRICTION | {"F_c": 3.0})
    through = DamperForward.near

    def near(self, data, model, rows, *_):
        found = through(self, data, model, rows)

        class Lazy(DamperForward):
            def predict_many(self, *given):
                return rows + share * (found.predict_many(*given) - rows)

        return Lazy(longest=found.longest)

    monkeypatch.setattr(DamperForward, "near", near)
    found = fit(grown, problem)
    np.testing.assert_array_equal(found.residual, problem.force - problem.predict(found.model))
    monkeypatch.setattr(DamperForward, "near", lambda self, *_: self)
    usual = fit(grown, problem)
    assert found.mse(problem.train) < (1.0 + AWAY) * usual.mse(problem.train)


@pytest.fixture(scope="module")
def step(sought):
    """A round of two effects beside the refitted model, as one that began with another effect in it."""
    model, problem = sought
    with pytest.MonkeyPatch.context() as patch:
        few = ("coulomb_friction", "preload")
        patch.setattr(DamperForward, "candidates", lambda _, m: tuple(m.catalogue[n] for n in few))
        base = replace(baseline(model, problem), effects=("gas_spring",))
        return one_round(base, problem, 0)


def test_a_search_that_goes_on_tries_nothing_twice(sought, step, monkeypatch):
    begun = afresh(step)
    assert step.taken.effects == ("gas_spring", "coulomb_friction")
    assert (begun.base.effects, begun.taken.effects) == ((), ("coulomb_friction",))
    assert any(c is begun.taken for c in begun.candidates)

    def never(*_, **__):
        raise AssertionError

    monkeypatch.setattr(investigation, "baseline", never)
    monkeypatch.setattr(investigation, "one_round", never)
    monkeypatch.setattr(investigation, "promising", lambda *_: False)
    found = search_effects(*sought, begun=begun)
    assert (found.effects, found.rounds[0]) == (("coulomb_friction",), begun)


@pytest.mark.parametrize("other", [False, True])
def test_the_last_study_is_gone_on_with_on_the_same_samples_only(sought, step, monkeypatch, other):
    model, problem = sought
    opened = SimpleNamespace(problem=problem, searched=model, lag=None, data=None, model=model)
    last = replace(problem, force=2.0 * problem.force) if other else problem
    best = baseline(model, problem)
    study = SimpleNamespace(
        problem=last, diagnosis=SimpleNamespace(further=step, best=best), opened=opened
    )
    seen = []
    monkeypatch.setattr(DamperLevel, "given", lambda *_: opened)
    monkeypatch.setattr(damper, "replace", lambda found, **_: found)
    monkeypatch.setattr(damper, "_restored", lambda found, _: found)
    monkeypatch.setattr(
        damper, "search_effects", lambda *_, known, begun, **__: seen.append((known, begun))
    )
    DamperLevel().searched(SimpleNamespace(last=study, rule=None, seed=0, model=model), None)
    ((known, begun),) = seen
    assert (known.effects, known.fit is best.fit, begun is None) == ((), not other, other)


def test_a_pair_that_stretches_deny_is_not_fitted_to_all_runs(sought, monkeypatch):
    model, problem = sought
    rows = np.arange(problem.motion.n)
    many = replace(problem)
    many.__dict__["practice"] = Practice(problem, rows)
    base, fits = baseline(model, many), []
    through = candidates.fit
    monkeypatch.setattr(
        candidates, "fit", lambda *a, **k: fits.append(k["max_iter"]) or through(*a, **k)
    )
    assert part_of(base.fit, many.practice).mse(problem.train) == base.seen
    refit(base, model.catalogue["preload"], many, target=0.5 * base.seen)
    assert fits[-1] == 0
    refit(base, model.catalogue["coulomb_friction"], many, target=0.5 * base.seen)
    assert fits[-1] > 0
