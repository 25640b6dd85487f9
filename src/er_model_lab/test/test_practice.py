"""Many runs: fits begin on stretches of them, and what is judged is fitted to all."""

from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.diagnosis import ranking, search
from er_model_lab.diagnosis.candidates import (
    baseline,
    effect_size,
    finished,
    refit,
    roughly_without,
    to_the_end,
    without,
)
from er_model_lab.diagnosis.ranking import may_win, refit_all
from er_model_lab.fitting.fit import fit, settled
from er_model_lab.problem import subset
from er_model_lab.problem.forward import ROUGH, DamperForward
from er_model_lab.problem.prepare import prepare
from er_model_lab.problem.problem import Problem
from er_models.files import load_model
from er_models.prediction import motion, predict, substeps
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import DT, GUO, imposed

SECONDS, RUNS = 12.0, 6
TRIED = ("coulomb_friction", "preload", "quadratic_damping", "gas_spring", "force_delay", "end_stop",
         "duty_dead_band", "fluid_inertia")  # fmt: skip


def runs():
    """Six runs of a damper with Coulomb friction; only the last ones have duty."""
    truth = load_model(GUO).with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})
    n, found = round(SECONDS / DT), []
    for r in range(RUNS):
        rng = np.random.default_rng(r)
        x, v, a, u = imposed(rng, n)
        u = u if r > 3 else np.zeros(n)
        force = predict(truth, motion(DT, x, v, u, a)) + 0.15 * rng.standard_normal(n)
        channels = {
            "deflection": x,
            "deflection_velocity": v + 1e-3 * rng.standard_normal(n),
            "duty": u,
        }
        found.append(Record(f"run {r}", np.arange(n) * DT, {**channels, "damper_force": force}))
    return found


@pytest.fixture(scope="module")
def prepared():
    return prepare(Dataset.of(runs()))


@pytest.fixture
def many(prepared, monkeypatch):
    """A minute counts as many runs, and a quarter of it is practised on; two effects are fitted to all."""
    assert prepared.practice is None, "which it keeps, whatever counts as many from here on"
    monkeypatch.setattr(subset, "MANY", 60.0)
    monkeypatch.setattr(subset, "PRACTISED", 18.0)
    monkeypatch.setattr(subset, "STRETCH", (3.0, 3.0))
    monkeypatch.setattr(ranking, "FINALISTS", 2)
    return replace(prepared)


def test_stretches_are_training_samples_that_hold_what_all_runs_hold(many):
    few = many.practice
    assert few is not None
    assert not many.held_out[few.rows].any()
    assert few.problem.scales == many.scales
    np.testing.assert_array_equal(few.problem.force, many.force[few.rows])
    assert few.problem.motion.u.max() == many.motion.u.max()
    assert 0.2 < few.problem.train.sum() / many.train.sum() < 0.5


def test_runs_held_out_are_never_practised_on(many, monkeypatch):
    monkeypatch.setattr(subset, "PRACTISED", 1000.0)
    few = many.practice
    assert few is not None
    assert few.rows.size == many.motion.n - round(SECONDS / DT)  # one run of six is held out
    assert not many.held_out[few.rows].any()


def test_few_or_single_runs_are_fitted_as_they_are(prepared, monkeypatch):
    assert prepared.practice is None
    monkeypatch.setattr(subset, "MANY", 10.0)
    alone = prepare(Dataset.of(runs()[:1]))
    assert alone.motion.n * alone.motion.dt > subset.MANY
    assert alone.practice is None


@pytest.fixture
def work(monkeypatch):
    """Steps of the integrator of all predictions."""
    found = []
    through = DamperForward.predict_many

    def counted(self, problem: Problem, model, vectors):
        steps = substeps(problem.motion.dt, self.longest)
        found.append(vectors.shape[0] * problem.motion.n * steps)
        return through(self, problem, model, vectors)

    monkeypatch.setattr(DamperForward, "predict_many", counted)
    return found


def test_a_fit_in_longer_steps_settles_where_the_usual_ones_see_the_least_for_less(prepared, work):
    model = load_model(GUO).with_effect("coulomb_friction", {"F_c": 0.3, "v_0": 0.01})
    near = prepared.near(model, prepared.predict(model), ROUGH)
    free = tuple(place for place in near.forward.free(model) if place[1] != "r")
    rough = fit(model, near, free, max_iter=2)
    work.clear()
    found, less = settled(rough, prepared), sum(work)
    work.clear()
    whole, all_work = fit(rough.model, prepared, free), sum(work)
    train = prepared.train
    seen = np.mean((prepared.force - prepared.predict(rough.model))[train] ** 2)
    assert seen > 1.005 * whole.mse(train)  # there is something to settle
    assert found.mse(train) - whole.mse(train) < 0.05 * (seen - whole.mse(train))
    left = prepared.force - prepared.predict(found.model)
    np.testing.assert_allclose(found.residual, left, atol=1e-9)
    assert less < 0.5 * all_work


def test_a_rough_look_says_what_is_plainly_needed_and_nothing_else_is_left_out_in_full(
    many, monkeypatch
):
    base = baseline(load_model(GUO), many)
    catalogue = base.fit.model.catalogue
    one = refit(base, catalogue["coulomb_friction"], many)
    assert one.ranked
    both = finished(refit(finished(one, many), catalogue["preload"], many), many)
    rough, whole = (f("coulomb_friction", many, both) for f in (roughly_without, without))
    assert (rough.ranked, whole.ranked) == (True, False)
    assert effect_size(rough, both) == pytest.approx(effect_size(whole, both), rel=0.02)
    asked = []

    def heard(which, problem, looks):
        asked.append(looks[which].effects)
        return to_the_end(which, problem, looks)

    monkeypatch.setattr(search, "to_the_end", heard)
    kept = search.prune(both, many, 0.25 * effect_size(whole, both))
    assert kept.effects == ("coulomb_friction",)
    assert not kept.ranked
    assert asked == [("coulomb_friction",)]


def test_of_few_runs_a_look_says_which_effects_are_worth_a_fit_to_the_end(prepared):
    base = baseline(load_model(GUO), prepared)
    effects = [base.fit.model.catalogue[name] for name in TRIED]
    found = refit_all(base, prepared, effects)
    whole = {e.name: refit(base, e, prepared) for e in effects}
    gains = {name: base.mse - c.mse for name, c in whole.items()}
    best = max(gains.values())
    assert found[0].name == "coulomb_friction"
    for c in found:
        assert c.ranked == (not may_win(gains[c.name], best)), c.name
        least = whole[c.name].seen
        assert c.seen == pytest.approx(least, rel=0.02 if c.ranked else 1e-4), c.name
        left = prepared.force - prepared.predict(c.fit.model)
        np.testing.assert_allclose(c.fit.residual, left, atol=1e-9)


@pytest.mark.slow
def test_the_best_effects_come_out_as_of_fits_to_all_runs_for_less_work(prepared, many, work):
    def ranked(problem):
        work.clear()
        base = baseline(load_model(GUO), problem)
        effects = [base.fit.model.catalogue[name] for name in TRIED]
        found = refit_all(base, problem, effects)
        return base, found, sum(work)

    base, whole, all_work = ranked(prepared)
    same, part, less_work = ranked(many)
    assert same.mse == pytest.approx(base.mse, rel=1e-3)
    assert part[0].name == whole[0].name == "coulomb_friction"
    assert part[0].mse == pytest.approx(whole[0].mse, rel=1e-3)
    assert {c.name for c in part} == set(TRIED)
    for place, c in enumerate(part):
        left = many.force - many.predict(c.fit.model)
        if place == 0:
            np.testing.assert_allclose(c.fit.residual, left, atol=1e-9)
        # the others are ranked in longer steps of the integrator
        assert np.std(c.fit.residual - left) < 0.05 * np.std(left)
    assert less_work < 0.8 * all_work
    # what a candidate and its base both have is there once
    known = same.fit.columns[0]
    assert sum(c.fit.columns[0] is known for c in part) >= len(TRIED) - ranking.FINALISTS
    assert all(c.fit.jacobian.shape == (many.motion.n, c.fit.theta.size) for c in part)
