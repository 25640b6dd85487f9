"""What a model predicts without a block is what it predicts when it was fitted without that block."""

from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline, cross_judged, effect_size, predicted, refit
from er_model_lab.fitting.cross_validation import _leaving_out, cross_validated
from er_model_lab.fitting.deviations import standard_deviations, with_deviations
from er_model_lab.fitting.fit import fit
from er_model_lab.problem.held_out import FOLDS
from er_models.files import load_model
from lab_help import FORCE_NOISE, GUO, problem_of


def test_one_step_is_as_good_as_fitting_again():
    model, problem = problem_of("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})
    full = fit(model.with_effect("coulomb_friction"), problem, max_iter=30)
    found, losses = cross_validated(full, problem)
    for b in (0, 5, FOLDS - 1):
        fold = np.where(problem.fold == b, -1, problem.fold)
        again = fit(full.model, replace(problem, fold=fold), max_iter=30)
        rows = problem.fold == b
        assert losses[b] == pytest.approx(np.mean(again.residual[rows] ** 2), rel=0.01)
        assert np.std(found[rows] - again.residual[rows]) < 0.1 * FORCE_NOISE


@pytest.mark.parametrize(
    ("effect", "values", "seed"),
    [("freeplay", {"b": 2.3e-5}, 6), ("cavitation", {"F_v": -10.0}, 1)],
)
def test_an_effect_that_jumps_is_not_lost_by_a_straight_line(effect, values, seed):
    model, problem = problem_of(effect, values, seed=seed)
    base = baseline(model, problem)
    found = refit(base, model.catalogue[effect], problem)
    assert found.fit.mse(problem.train) < 0.8 * base.fit.mse(problem.train)
    assert found.mse == pytest.approx(found.fit.mse(problem.train), rel=0.1)


def test_a_refinement_stays_as_it_is_where_a_block_is_left_out():
    """A void that opens a few times tells its shape nowhere else, and would be held against the cavitation."""
    model, problem = problem_of("cavitation", {"F_v": -10.0, "s_y": 0.7, "n_g": 3.0}, seed=1)
    found = refit(baseline(model, problem), model.catalogue["cavitation"], problem)
    moves = dict(
        zip(
            found.fit.free,
            np.abs(_leaving_out(found.fit, problem, refined=False)).max(axis=0),
            strict=True,
        )
    )
    assert moves["cavitation", "F_v"] > 0.0
    assert moves["cavitation", "n_g"] == moves["cavitation", "s_y"] == 0.0


def test_left_out_blocks_never_gain_more_than_the_fit():
    """A straight line that fails for the model alone must not look like an effect."""
    model, problem = problem_of(None, {}, seed=7, seconds=12.0)
    base = baseline(model, problem)
    bad = replace(base, mse=1.1 * base.mse)
    for name in ("end_stop", "coulomb_friction"):
        found = refit(bad, model.catalogue[name], problem)
        gained = base.fit.mse(problem.train) - found.fit.mse(problem.train)
        signed = np.sign(gained) * np.sqrt(abs(gained))
        assert effect_size(bad, found) == pytest.approx(signed, abs=1e-9)
        assert effect_size(base, found) <= effect_size(bad, found)


@pytest.mark.parametrize("corner", [64, 8], ids=["sharp", "rounded"])
def test_cavitation_is_also_a_force_that_is_only_cut_off(corner):
    """The fluid cannot pull more than 8 N, and nothing comes back late: F / (1 + (F / 8 N)^n)^(1/n)."""

    def cut(force, x):
        pull = -(force - load_model(GUO).value("passive", "k0") * x)
        lost = pull - pull / (1.0 + (np.maximum(pull, 0.0) / 8.0) ** corner) ** (1.0 / corner)
        return force + lost

    model, problem = problem_of(None, {}, bent=cut)
    noise = np.sqrt(baseline(*problem_of(None, {})).fit.mse(problem.train))
    base = baseline(model, problem)
    found = refit(base, model.catalogue["cavitation"], problem)
    assert np.sqrt(base.fit.mse(problem.train)) > 1.2 * noise
    assert np.sqrt(found.fit.mse(problem.train)) < 1.04 * noise


def test_a_model_that_predicts_no_numbers_is_no_candidate_and_stops_nothing():
    """What grows beyond measure on one run takes nothing from the others: it is told by no number, and left out."""
    model, problem = problem_of(None, {}, seconds=8.0)
    fitted = fit(model.with_effect("coulomb_friction"), problem, max_iter=1)
    nothing = np.where(np.arange(fitted.residual.size) < 900, fitted.residual, np.nan)
    away = cross_judged(("coulomb_friction",), replace(fitted, residual=nothing), problem)
    assert (away.mse, away.seen) == (np.inf, np.inf)
    assert np.isinf(standard_deviations(away.fit, problem)).all()
    assert with_deviations(away.fit, problem).deviations
    base = baseline(model, problem)
    assert predicted([away, base]) == [base]
    assert predicted([away]) == [away]
