"""When an effect is worth a name: what chance gives, ties, and effects that are needed together."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from er_model_lab.diagnosis import passing, search, special_cases
from er_model_lab.diagnosis.candidates import (
    baseline,
    cross_judged,
    effect_size,
    finished,
    refit,
)
from er_model_lab.diagnosis.coverage import coverage
from er_model_lab.diagnosis.determined import strange, unseen
from er_model_lab.diagnosis.investigation import _alternatives, _standing, judge, one_effect
from er_model_lab.diagnosis.leftover_structure import burst_shares, bursts, filtered
from er_model_lab.diagnosis.noise_floor import Floor, noise_floor
from er_model_lab.diagnosis.null import Null, simulate_null
from er_model_lab.diagnosis.passing import (
    STEADY,
    beyond_motion,
    block_gains,
    paired_t,
    passes,
    threshold,
)
from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.diagnosis.search import Round, decided, partners, promising, swapped
from er_model_lab.diagnosis.ties import DOUBT, SURE, complexity, nested, rivals, tied
from er_model_lab.fitting.fit import fit
from er_model_lab.level.study import Study
from er_model_lab.problem.motion_error import drawn
from er_model_lab.problem.prepare import prepare
from er_model_lab.residual.errors import size_notes
from er_model_lab.results.diagnosis import diagnosis_json
from er_models.errors import InputError
from er_models.files import load_model
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import FORCE_NOISE, GUO, asked, imposed, problem_of
from scipy.signal import lfilter


@pytest.mark.parametrize("accelerometers", [True, False])
def test_drawn_motions_miss_the_fused_one_as_it_misses_the_true_one(accelerometers):
    _, problem = problem_of(None, {}, seed=4, accelerometers=accelerometers)
    rng, m = np.random.default_rng(0), problem.motion
    x, v, _, _ = imposed(np.random.default_rng(4), m.n)
    draws = [drawn(problem, rng) for _ in range(4)]
    for true, seen, shown in (
        (x, m.x, [d.x for d in draws]),
        (v, m.v, [d.v for d in draws]),
    ):
        missed = np.std((true - seen)[problem.train])
        assert np.std([(y - seen)[problem.train] for y in shown]) == pytest.approx(
            missed, rel=0.25
        )


def test_without_a_deflection_drawn_motions_miss_the_true_one_about_its_middle():
    _, whole = problem_of(None, {}, seed=4, seconds=60.0, accelerometers=False)
    n, rng = whole.motion.n, np.random.default_rng(0)
    x, v, _, u = imposed(np.random.default_rng(4), n)
    channels = {
        "deflection_velocity": v + 1e-3 * rng.standard_normal(n),
        "duty": u,
        "damper_force": whole.force,
    }
    problem = prepare(Dataset.of([Record("velocity", np.arange(n) * 0.005, channels)]))
    missed = np.std(x - problem.motion.x)
    shown = np.std([drawn(problem, rng).x - problem.motion.x for _ in range(4)])
    assert shown == pytest.approx(missed, rel=0.5)


GATE = np.arange(1000) % 10 == 0
ERRORS = Null(np.zeros(0), 1.0, 1.0, 0.0, np.where(GATE, 10.0, 0.0), least=2.0)
"""Errors of a motion that act in one sample of ten."""


def leaving(square):
    """A candidate that leaves this mean square (n,) in each sample."""
    mean = float(np.mean(square))
    return SimpleNamespace(
        ranked=False,
        name="of",
        residual=np.sqrt(square),
        losses=np.full(12, mean),
        mse=mean,
        seen=mean,
        left=mean,
    )


BEFORE, ON_PLATEAUS = leaving(np.full(GATE.size, 2.0)), leaving(np.where(GATE, 2.0, 1.0))
AT_THE_GATE, LOSES_THERE = leaving(np.where(GATE, 0.0, 2.0)), leaving(np.where(GATE, 12.0, 1.0))


def test_a_gain_counts_beyond_the_errors_of_the_motion_where_they_act():
    problem = SimpleNamespace(train=np.ones(GATE.size, bool))
    sizes = [
        beyond_motion(BEFORE, c, ERRORS, problem) for c in (ON_PLATEAUS, AT_THE_GATE, LOSES_THERE)
    ]
    assert sizes == pytest.approx([np.sqrt(0.9), 0.0, 0.0], abs=1e-6)


@pytest.mark.parametrize(
    ("found", "small", "taken"),
    [(ON_PLATEAUS, False, False), (ON_PLATEAUS, True, True), (AT_THE_GATE, True, False)],
)
def test_small_steps_believe_what_acts_on_the_plateaus(found, small, taken, monkeypatch):
    _alone(monkeypatch)
    problem = SimpleNamespace(train=np.ones(GATE.size, bool), cycles=())
    step = search.decided(BEFORE, [found], ERRORS, problem, replace(RULE, small_steps=small))
    assert (step.taken is found) is taken
    assert step.threshold < 0.2 if taken else step.threshold == ERRORS.least


def _alone(monkeypatch, loose=()):
    """Candidates stand for themselves; the values of some are not determined."""
    monkeypatch.setattr(search, "far_better", lambda base, form, able, limit: True)
    monkeypatch.setattr(search, "tied", lambda base, able, problem, limit: able[:1])
    monkeypatch.setattr(search, "loose", lambda candidate, problem: loose)
    monkeypatch.setattr(search, "strange", lambda candidate: False)
    monkeypatch.setattr(search, "stands_in", lambda *_: False)


def test_small_steps_take_no_effect_whose_values_the_data_do_not_determine(monkeypatch):
    _alone(monkeypatch, loose=("best",))
    problem = SimpleNamespace(train=np.ones(GATE.size, bool), cycles=())
    best, next_best = leaving(np.full(GATE.size, 0.5)), leaving(np.full(GATE.size, 1.0))
    best.name, next_best.name = "best", "next"
    for small, taken in ((False, best), (True, next_best)):
        rule = replace(RULE, small_steps=small)
        step = search.decided(BEFORE, [best, next_best], replace(ERRORS, least=0.0), problem, rule)
        assert step.taken is taken


@pytest.mark.parametrize(("small", "taken"), [(False, False), (True, True)])
def test_small_steps_ask_for_less_steadiness(small, taken, monkeypatch):
    """Gains of two to three standard errors in two blocks of three, of twice the size that counts."""
    _alone(monkeypatch)
    gains = np.array([-0.7, 3.6, 5.8, 13.3, -3.3, 8.9, 4.5, 9.0, 13.2, -2.3, -2.4, 2.7]) / 40.0
    found = leaving(np.full(GATE.size, 2.0 - gains.mean()))
    found.losses = BEFORE.losses - gains
    assert 2.0 < passing.paired_t(gains) < 3.0
    problem = SimpleNamespace(train=np.ones(GATE.size, bool), cycles=())
    null = Null(np.zeros(0), 0.0, 1.0, 0.0, np.zeros(0), least=0.5 * np.sqrt(gains.mean()))
    step = search.decided(BEFORE, [found], null, problem, replace(RULE, small_steps=small))
    assert (step.taken is found) is taken


def test_chance_passes_its_threshold_as_often_as_it_is_allowed_to():
    sizes = np.sqrt(np.random.default_rng(3).exponential(2.0, 4096))
    for alarm in (0.3, 0.05, 0.01):
        rates, values = [], []
        for part in sizes.reshape(-1, 64):
            null = Null(part, 0.0, 1.0, 0.0, np.zeros(0))
            limit = null.threshold(alarm)
            rates.append(np.exp(-(limit**2) / 2.0))
            values.append(null.p_value(limit))
        assert np.mean(rates) == pytest.approx(alarm, rel=0.5)
        assert np.median(values) == pytest.approx(alarm, rel=0.3)


def test_a_complete_model_stays_below_what_chance_gives_and_an_effect_does_not():
    limits = {}
    for effect, values in ((None, {}), ("coulomb_friction", {"F_c": 0.5, "v_0": 0.003})):
        model, problem = problem_of(effect, values, seed=5)
        base = baseline(model, problem)
        found = [
            refit(base, model.catalogue[n], problem) for n in ("coulomb_friction", "end_stop")
        ]
        null = simulate_null(base, found, problem, seed=1)
        limits[effect] = null.threshold(0.01), np.sqrt(max(base.mse - found[0].mse, 0.0))
    assert limits[None][1] < limits[None][0] < 0.05
    assert limits["coulomb_friction"][1] > 3.0 * limits["coulomb_friction"][0]


def test_whether_the_force_was_read_before_or_after_a_jump_of_the_duty_is_no_lag():
    model, problem = problem_of("field_stiffness", {"k_u": 3000.0}, seed=6, early=True)
    base = refit(baseline(model, problem), model.catalogue["field_stiffness"], problem)
    lagging = refit(base, model.catalogue["force_lag"], problem)
    assert effect_size(base, lagging) < 0.02
    jumps = np.flatnonzero(np.diff(problem.motion.u)) + 1
    assert jumps.size > 10
    assert not problem.used[jumps].any()


def test_what_cannot_take_the_place_of_an_effect_is_not_looked_at_more_closely(monkeypatch):
    model, problem = problem_of("coulomb_friction", {"F_c": 0.5, "v_0": 0.003}, seed=5)
    rest = baseline(model, problem)
    right = refit(rest, model.catalogue["coulomb_friction"], problem)
    rest, closer = replace(rest, effects=("coulomb_friction",)), []
    monkeypatch.setattr(search, "chosen_among", lambda c, _: closer.append(c.name) or c)
    for name in ("coulomb_friction", "end_stop"):
        search.exchanged(name, problem, rest, 0, right.left)
    assert closer == ["coulomb_friction"]
    search.exchanged("end_stop", problem, rest, 0)
    assert closer == ["coulomb_friction", "end_stop"]


def test_a_parameter_that_one_block_alone_shows_is_no_chance_of_a_huge_effect():
    model, problem = problem_of(None, {}, seed=6)
    base = baseline(model, problem)
    found = [refit(base, model.catalogue[n], problem) for n in ("coulomb_friction", "preload")]
    limit = simulate_null(base, found, problem, seed=1).threshold(0.01)
    once = 1e-6 * np.random.default_rng(0).standard_normal((problem.motion.n, 1))
    once[np.flatnonzero(problem.train & (problem.fold == 4))[:3]] = 1.0
    fitted = replace(base.fit, columns=(base.fit.jacobian, once))
    spiked = simulate_null(replace(base, fit=fitted), found, problem, seed=1)
    assert spiked.threshold(0.01) == pytest.approx(limit, rel=0.2)


@pytest.mark.parametrize("rule", [(0.0,), (1.0,), (0.01, -0.1), (0.01, 0.1, 1.5)])
def test_a_rule_that_cannot_be_is_refused(rule):
    with pytest.raises(InputError):
        Rule(*rule)


def test_the_rule_is_the_one_that_the_documents_state_and_the_scores_were_made_with():
    assert Rule(false_alarm=0.01, smallest=0.12, helps=0.2) == RULE


@pytest.fixture(scope="module")
def friction():
    model, problem = problem_of(
        "stribeck_friction", {"F_c": 0.5, "F_s": 1.5, "v_s": 0.01, "v_0": 0.002}, seed=2
    )
    base = baseline(model, problem)
    names = ("stribeck_friction", "coulomb_friction")
    found = [refit(base, model.catalogue[n], problem, max_iter=30) for n in names]
    return base, sorted(found, key=lambda c: c.mse), problem


def test_two_seconds_are_enough_to_fit_and_to_score():
    model, problem = problem_of("coulomb_friction", {"F_c": 1.5, "v_0": 0.003}, seconds=2.005)
    base = baseline(model, problem)
    found = refit(base, model.catalogue["coulomb_friction"], problem)
    assert paired_t(block_gains(found, base, problem)) > 1.0
    floor = noise_floor(problem, found, simulate_null(base, [], problem, 0), seed=0)
    assert floor.floor == pytest.approx(FORCE_NOISE, rel=0.3)
    with pytest.raises(
        InputError, match=r"expected at least 100 samples to fit.*, found \d+ and \d+ in"
    ):
        problem_of(None, {}, seconds=1.5)


def test_a_damper_that_stands_still_is_said_to_stand_still():
    rng, n = np.random.default_rng(0), 3000
    sizes = {"deflection": 2e-5, "deflection_velocity": 1e-3, "damper_force": FORCE_NOISE}
    noise = {name: size * rng.standard_normal(n) for name, size in sizes.items()}
    still = prepare(Dataset.of([Record("still", np.arange(n) * 0.005, noise)]))
    assert "stands still" in coverage(still).blocking[0]
    _, moving = problem_of(None, {}, seconds=6.0)
    assert not any("still" in text for text in coverage(moving).blocking)


def test_a_duty_that_changes_slowly_is_not_called_constant():
    _, problem = problem_of(None, {}, seconds=6.0)
    slow = 0.15 * (1.0 - np.cos(0.3 * problem.motion.t))
    for u, said in ((slow, "without steps"), (0.0 * slow, "never changes")):
        (hint,) = coverage(replace(problem, motion=replace(problem.motion, u=u))).hints
        assert said in hint


def test_a_force_of_another_size_is_said_and_one_that_a_term_is_missing_from_is_not():
    model, problem = problem_of("coulomb_friction", {"F_c": 1.5, "v_0": 0.003}, seconds=6.0)
    assert size_notes(problem, problem.force - problem.predict(model)) == ()
    for factor in (1e-3, 50.0, -1.0):
        other = replace(problem, force=factor * problem.force)
        (note,) = size_notes(other, other.force - problem.predict(model))
        assert float(note.split("is ")[1].split()[0]) == pytest.approx(factor, rel=0.3)


def test_a_diagnosis_says_so_too_although_its_refit_takes_any_unit():
    model, problem = problem_of(None, {}, seconds=6.0)
    other = replace(problem, force=1e-3 * problem.force)
    found = one_effect(model, other, None, seed=0)
    study = Study(asked(model, other), found)
    assert any("another unit" in note for note in diagnosis_json(study, found.model)["notes"])


def test_a_small_difference_that_is_sure_is_no_tie(friction):
    base, found, problem = friction
    near = tied(base, found, problem, limit=0.01)
    assert [c.name for c in near] == ["stribeck_friction"]


def scaled_by(factors, candidate, problem):
    """The candidate with its residual times factors, one or (n,)."""
    residual = candidate.residual * factors
    folds = range(candidate.losses.size)
    losses = np.array([np.mean(residual[problem.fold == k] ** 2) for k in folds])
    mse = float(np.mean(residual[problem.train] ** 2))
    fitted = replace(candidate.fit, residual=candidate.fit.residual * factors)
    return replace(candidate, fit=fitted, residual=residual, losses=losses, mse=mse, seen=mse)


def test_a_rival_of_as_many_parameters_that_hardly_errs_more_is_a_tie(friction):
    """A lag of the force leaves 1 % more than a delay, surely so, where both take nearly all of the error."""
    _, (best, *_), problem = friction
    base, small, rival = (scaled_by(factor, best, problem) for factor in (8.0, 4.0, 1.2))
    behind = float(np.sqrt(rival.mse - best.mse))
    assert paired_t(block_gains(best, rival, problem)) > SURE
    assert len(tied(base, [best, rival], problem, limit=behind / 1.4)) == 2  # 0.9965 of the size
    assert tied(base, [best, rival], problem, limit=behind / 1.6) == [best]
    assert tied(small, [best, rival], problem, limit=behind / 1.4) == [best]  # 0.985 of the size


@pytest.mark.parametrize(("rise", "first"), [(1.04, True), (1.06, False)])
def test_of_two_tied_effects_the_one_that_held_out_data_refuse_is_told_last(friction, rise, first):
    """Remanence took a rise from 32 N to 38 N there, where pre-sliding hysteresis lowered it to 29 N."""
    _, (best, *_), whole = friction
    there = np.arange(whole.force.size) % 4 == 0
    problem = replace(whole, held_out=there, fold=np.where(there, -1, whole.fold))
    base, best, rival = (scaled_by(factor, best, problem) for factor in (8.0, 1.0, 1.0001))
    left = np.where(there, 8.0 * rise, 1.0) * best.fit.residual
    beside = replace(best, fit=replace(best.fit, residual=left))
    told = tied(base, [beside, rival], problem, limit=0.05)
    assert (told[0] is beside) is first
    assert len(told) == 2


def test_a_rival_that_errs_in_a_few_blocks_and_is_better_in_none_is_no_tie(friction):
    """Where a stop is touched in three seconds of many, unequally hard, the paired t stays below 2."""
    _, (best, *_), problem = friction

    def worse(factors):
        return scaled_by(factors, best, problem)

    second = (np.cumsum(problem.train) - 1) // problem.second
    few = np.select([second == 3, second == 6, second == 8], [9.0, 3.0, 2.5], 1.0)
    own, base, rival = worse(1.0), worse(8.0), worse(few)
    assert paired_t(block_gains(own, rival, problem)) < 2.0
    assert tied(base, [own, rival], problem, limit=0.02) == [own]
    other = worse(
        np.where(second == 1, 3.0, 1.0)
    )  # where the rival is better: chance may have shared them out
    assert len(tied(base, [other, rival], problem, limit=0.02)) == 2


def test_a_rival_far_behind_is_no_tie_and_never_told_first(friction):
    """Whose error comes in a few blocks of 9 times the square: told apart where it is behind in half of the blocks."""
    _, (best, plain, *_), problem = friction
    base = scaled_by(8.0, best, problem)
    blocks = (np.cumsum(problem.train) - 1) // problem.second
    spikes = np.where(blocks == 2, 6.0, 1.0)

    def near(elsewhere):
        rival = scaled_by(np.where(blocks % 2 == 0, spikes, elsewhere), best, problem)
        rival = replace(rival, fit=plain.fit, effects=plain.effects)
        behind = float(np.sqrt(rival.mse - best.mse))
        assert paired_t(block_gains(best, rival, problem)) < DOUBT
        return [tied(base, [best, rival], problem, limit=behind / by) for by in (2.9, 3.1)]

    assert [len(found) for found in near(1.001)] == [2, 1]
    within, beyond = near(0.9)
    assert (within[1], beyond[0]) == (best, best), "the simpler one first, unless it is far behind"
    assert (len(within), len(beyond)) == (2, 2)


def test_a_simpler_rival_is_told_after_one_that_leaves_plainly_less(friction):
    """A brake behind a gap that leaves the noise, beside a joint that leaves twice as much of it in every second."""
    _, (best, plain, *_), problem = friction
    base = scaled_by(20.0, best, problem)
    first = {}
    for factor in (1.1, 1.2):
        rival = scaled_by(factor, best, problem)
        rival = replace(rival, fit=plain.fit, effects=plain.effects)
        near = tied(base, [best, rival], problem, limit=float(np.sqrt(rival.mse - best.mse)) / 1.4)
        assert len(near) == 2
        first[factor] = near[0].name
    assert first == {1.1: "coulomb_friction", 1.2: "stribeck_friction"}


def test_a_friction_that_the_field_may_raise_is_no_law_of_the_duty():
    model, still = problem_of(None, {}, seed=3)
    steady = replace(still, motion=replace(still.motion, u=np.zeros(still.motion.n)))
    base = baseline(model, steady)
    for name, law in (("bouc_wen_hysteresis", False), ("field_friction", True)):
        grown = refit(base, model.catalogue[name], steady, max_iter=0)
        assert unseen(grown, steady) is law


def test_a_free_exponent_that_hardly_helps_is_tied_with_the_form_that_has_none():
    """Turbulent damping as v^1.75 (Blasius): neither v^2 nor a power law of all the damping, each nearly."""
    model, problem = problem_of(None, {}, seed=3)
    v = problem.motion.v
    problem = replace(problem, force=problem.force + 200.0 * v * np.abs(v) ** 0.75)
    base = baseline(model, problem)
    plain, rich = (
        refit(base, model.catalogue[n], problem) for n in ("quadratic_damping", "shear_thinning")
    )
    behind = float(np.sqrt(plain.mse - rich.mse))
    assert paired_t(block_gains(rich, plain, problem)) > DOUBT  # sure, and yet next to nothing
    near = tied(base, [rich, plain], problem, limit=behind / 1.4)
    assert [c.name for c in near] == ["quadratic_damping", "shear_thinning"]
    assert tied(base, [rich, plain], problem, limit=behind / 1.6) == [rich]


def test_stribeck_friction_without_a_breakaway_is_coulomb_friction():
    model, problem = problem_of("coulomb_friction", {"F_c": 0.5, "v_0": 0.003}, seed=3)
    base = baseline(model, problem)
    plain = refit(base, model.catalogue["coulomb_friction"], problem, max_iter=30)
    own = plain.fit.model.effects["coulomb_friction"]
    values = {"F_c": own["F_c"], "v_0": own["v_0"], "F_s": 0.0, "v_s": 0.4}
    same = plain.fit.model.without_effect("coulomb_friction").with_effect(
        "stribeck_friction", values
    )
    rich = cross_judged(("stribeck_friction",), fit(same, problem, max_iter=0), problem)
    rich = replace(rich, mse=0.9999 * plain.mse)
    near = tied(base, [rich, plain], problem, limit=0.01)
    assert [c.name for c in near] == ["coulomb_friction", "stribeck_friction"]
    assert nested(plain, rich, problem)
    assert not rivals(plain, rich, problem)
    assert special_cases.plain(rich, problem, 0.01)[0].effects == ("coulomb_friction",)


@pytest.mark.parametrize(
    ("hidden", "named"), [(0.0, "coulomb_friction"), (1.5, "stribeck_friction")]
)
def test_beside_other_effects_a_friction_is_no_richer_than_it_needs_to_be(hidden, named):
    """What bent a friction before another effect was there no longer counts once it is."""
    values = {"F_c": 1.0, "F_s": hidden, "v_s": 0.01, "v_0": 0.003}
    model, problem = problem_of("stribeck_friction", values, seed=3)
    begun = {**values, "F_s": 0.3, "v_s": 0.3}
    both = model.with_effect("preload", {"F_0": 0.0}).with_effect("stribeck_friction", begun)
    found = cross_judged(("preload", "stribeck_friction"), fit(both, problem), problem)
    assert special_cases.plain(found, problem, 0.03)[0].effects == ("preload", named)


def test_a_breakaway_with_a_long_tail_is_met_by_its_form():
    """Hess and Soom's law; a fit that begins at an exponential does not get there."""
    values = {"F_c": 0.5, "F_s": 4.0, "v_s": 0.012, "v_0": 0.003, "s": 1.0}
    model, problem = problem_of("stribeck_friction", values, seed=3)
    base = baseline(model, problem)
    found = refit(base, model.catalogue["stribeck_friction"], problem, max_iter=30)
    assert found.fit.model.value("stribeck_friction", "s") == pytest.approx(1.0, abs=0.3)
    assert (
        np.sqrt(found.mse) < 1.2 * FORCE_NOISE
    )  # what the errors of the motion cause is there, too


def test_what_the_motions_errors_hide_is_said_to_be_hidden():
    """More than noise does, but no more than the motion sensors may cause: neither an effect nor a complete model."""
    said = {}
    for effect, values in ((None, {}), ("coulomb_friction", {"F_c": 0.07, "v_0": 0.003})):
        model, problem = problem_of(effect, values, seed=5, accelerometers=False)
        base = baseline(model, problem)
        found = [refit(base, model.catalogue["coulomb_friction"], problem)]
        null = simulate_null(base, found, problem, seed=1)
        step = Round(base, found, null, threshold(null, null.force_noise), None, [])
        noise = float(np.sqrt(found[0].mse))
        floor = Floor(noise, 0.0, noise, 0.0, 0.0, {}, (0.0, 0.0, 0.0))
        said[effect] = judge(base, base, [step], floor, problem)
    assert said[None].verdict == "adequate"
    assert said["coulomb_friction"].verdict == "insufficient_data"
    assert "record both accelerations" in said["coulomb_friction"].reasons[-1]


def test_what_trees_predict_of_no_more_than_measured_noise_is_nothing_unknown():
    """A sharp friction at its reversals: the errors of the motion are there, and so can be predicted."""
    model, problem = problem_of(None, {}, seed=5)
    base = baseline(model, problem)
    null = replace(simulate_null(base, [], problem, seed=1), least=0.0)
    step = Round(base, [], null, threshold(null, null.force_noise), None, [])
    left = float(np.sqrt(base.mse))
    floor = Floor(0.8 * left, 0.3, 0.8 * left, 0.0, 0.0, {}, (0.0, 0.0, 0.0))
    said = {
        share: judge(base, base, [step], replace(floor, measured=share * left), problem)
        for share in (0.9, 1.1)
    }
    assert said[0.9].verdict == "unknown_effect"
    assert said[1.1].verdict == "insufficient_data"
    assert "hide whether anything is missing" in said[1.1].reasons[-1]


def test_what_noise_does_not_leave_is_seen_and_noise_is_not():
    model, problem = problem_of(None, {}, seed=6)
    residual, none = baseline(model, problem).fit.residual, np.zeros(problem.motion.n)
    rng, n = np.random.default_rng(1), problem.motion.n
    edges = 3.0 * lfilter([1.0], [1.0, -0.8], np.diff(problem.motion.u, prepend=0.0))
    events = np.repeat(rng.random(n // 10 + 1) < 0.04, 10)[:n]
    assert filtered(problem, residual, residual)[0] < 0.02
    assert bursts(problem, residual, none) == 0.0
    share, unseen, worth = filtered(problem, residual + edges, residual + edges)
    assert min(share, unseen) > 0.03
    assert next(iter(worth)) == "duty change, its past"
    assert bursts(problem, residual + 0.5 * events, none) > 0.1


def test_a_gap_is_found_though_each_size_has_a_valley_of_its_own():
    b = 2e-4
    model, problem = problem_of("freeplay", {"b": b}, seconds=12.0)
    base = baseline(model, problem)
    found = finished(refit(base, model.catalogue["freeplay"], problem), problem)
    assert found.fit.model.value("freeplay", "b") == pytest.approx(b, rel=0.1)
    assert np.sqrt(found.seen) < 1.08 * FORCE_NOISE


def test_a_gap_beside_another_effect_promises_more_though_no_regression_sees_it():
    model, problem = problem_of("force_lag", {"T_f": 0.003}, seconds=12.0)
    gap = problem.predict(model.with_effect("freeplay", {"b": 3e-5})) - problem.predict(model)
    null = Null(np.zeros(0), 0.0, 1.0, 0.0, np.zeros(0))
    for force, more in ((problem.force, False), (problem.force + gap, True)):
        data = replace(problem, force=force)
        base = baseline(model, data)
        lag, play = (refit(base, model.catalogue[e], data) for e in ("force_lag", "freeplay"))
        assert promising(lag, Round(base, [lag, play], null, 0.02, lag, []), data) is more


def test_bursts_that_chance_makes_too_are_none():
    _, problem = problem_of(None, {}, seed=6)
    n, rng = problem.motion.n, np.random.default_rng(2)
    events = np.where(np.repeat(rng.random(n // 40 + 1) < 0.1, 40)[:n], 3.0, 1.0)
    loud, none = 0.15 * rng.standard_normal((2, n)) * events, np.zeros(n)
    drawn_so, share = burst_shares(problem, loud, none).max(), bursts(problem, loud[0], none)
    assert share > 0.1
    assert bursts(problem, loud[0], none, float(drawn_so)) == 0.0
    assert bursts(problem, loud[0], none, 0.9 * share) == share


@pytest.mark.parametrize(
    ("gains", "there"),
    [
        ([0.051, 0.012, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4] + 4 * [-1e-4], True),
        ([0.063, 0.0, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4] + 4 * [-1e-4], False),
        ([0.051, 0.022, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4] + 4 * [-3e-3], False),
    ],
)
def test_what_acts_seldom_counts_where_it_acts_more_than_once_and_harms_nowhere(
    friction, gains, there
):
    base = friction[0]
    fall = float(np.mean(gains))
    found = replace(base, losses=base.losses - gains, mse=base.mse - fall, seen=base.seen - fall)
    assert passes(base, found, 0.028) is there


def test_a_little_more_or_less_of_an_effect_decides_nothing_about_how_steady_it_must_be(friction):
    """Of twelve blocks nine gain: enough at 2.9 times what counts as at 3.1 times, where nothing is asked any more."""
    base = replace(friction[0], losses=np.full(12, 10.0))
    found = replace(base, mse=base.mse - 1.0, seen=base.seen - 1.0)
    gains = np.array([9.0, 1.0, 1.0, 0.5, 0.5, 0.3, 0.3, 0.2, 0.2, -0.3, -0.3, -0.4])
    assert paired_t(gains) < STEADY

    def there(gains, size):
        return passes(base, replace(found, losses=base.losses - gains), 1.0 / size)

    assert [there(gains, size) for size in (2.0, 2.5, 2.9, 3.1)] == [False, False, True, True]
    seven = np.where(np.arange(12) == 7, -0.2, np.where(np.arange(12) == 8, -0.2, gains))
    assert [there(seven, size) for size in (2.6, 2.9, 3.1)] == [False, True, True]


def test_what_was_only_ranked_is_fitted_to_its_end_before_it_is_taken(friction):
    base, found, problem = friction
    null = Null(np.zeros(0), 0.0, 1.0, 0.0, np.zeros(0))
    off = 1e-3 * np.ones(problem.motion.n)  # as longer steps of the integrator would be
    rough = [
        replace(c, fit=replace(c.fit, residual=c.fit.residual + off), ranked=True) for c in found
    ]
    taken = decided(base, rough, null, problem, RULE).taken
    assert (taken.name, taken.ranked) == (found[0].name, False)
    left = problem.force - problem.predict(taken.fit.model)
    np.testing.assert_allclose(taken.fit.residual, left, atol=1e-9)


def test_effects_that_are_both_needed_are_no_rivals(friction):
    base, found, _ = friction
    null = Null(np.zeros(0), 0.0, 1.0, 0.0, np.zeros(0))
    step = Round(base, found, null, 0.1, found[0], [c.name for c in found])
    both = replace(found[0], effects=tuple(c.name for c in found))
    assert _alternatives(both, [step]) == ()
    assert _alternatives(found[0], [step]) == (tuple(c.name for c in found),)


def test_what_explains_little_is_taken_where_that_is_asked_for(friction):
    base, found, problem = friction
    null = Null(np.zeros(0), 0.0, 1.0, 0.0, np.zeros(0))
    weak = replace(found[0], mse=base.mse - 0.15 * (base.mse - found[0].mse))
    floor = Floor(np.sqrt(found[0].mse), 0.0, 0.0, 0.0, 0.3, {}, (0.0, 0.0, 0.0))
    step = Round(base, [weak], null, 0.01, weak, [weak.name])
    strict = judge(base, weak, [step], floor, problem)
    assert (strict.verdict, strict.effects) == ("unknown_effect", ())
    assert "set helps to 0.1" in strict.reasons[-1]
    asked = judge(base, weak, [step], floor, problem, rule=Rule(helps=0.1))
    assert (asked.verdict, asked.effects) == ("partial", weak.effects)


@pytest.mark.parametrize(("left", "said"), [(0.02, "missing_effect"), (0.2, "partial")])
def test_three_effects_that_leave_more_than_noise_may_stand_for_another(friction, left, said):
    base, found, problem = friction
    names = ("stribeck_friction", "coulomb_friction", "freeplay")
    model = found[0].fit.model
    for name in names[1:]:
        start = {q.name: 0.0 for q in model.catalogue[name].parameters}
        model = model.with_effect(name, start)
    three = replace(found[0], effects=names, fit=replace(found[0].fit, model=model))
    floor = Floor(np.sqrt((1.0 - left) * three.mse), 0.0, 0.0, 0.0, 0.0, {}, (0.0, 0.0, 0.0))
    step = Round(base, found, Null(np.zeros(0), 0.0, 1.0, 0.0, np.zeros(0)), 0.01, found[0], [])
    assert judge(base, three, [step], floor, problem).verdict == said
    two = replace(three, effects=names[:2])
    assert judge(base, two, [step], floor, problem).verdict == "missing_effect"


@pytest.mark.parametrize("ties", [["shear_thinning", "coulomb_friction"], ["shear_thinning"]])
def test_a_tie_or_a_lead_counts_beside_everything_else_that_is_missing(ties, monkeypatch):
    """Beside another missing effect the friction was taken for a thinning; in the whole model it no longer is."""
    weighed = list[set[str]]()

    def spied(base, able, *rest):
        weighed.append({c.name for c in able})
        return tied(base, able, *rest)

    monkeypatch.setattr(search, "tied", spied)
    model, problem = problem_of("coulomb_friction", {"F_c": 0.5, "v_0": 0.003}, seed=3)
    drag = 0.05 * problem.scales.force * problem.motion.x / problem.scales.deflection
    problem = replace(problem, force=problem.force + drag * problem.motion.u / 0.3)
    base = baseline(model, problem)
    catalogue = model.catalogue
    names = ("shear_thinning", "coulomb_friction")
    found = [refit(base, catalogue[n], problem) for n in names]
    null = Null(np.zeros(0), 0.0, 1.0, 0.0, np.zeros(0))
    step = Round(base, found, null, 0.02, found[0], ties)
    both = refit(found[0], catalogue["field_stiffness"], problem)
    best, ties = swapped(both, [step], problem)
    assert best.effects == ("coulomb_friction", "field_stiffness")
    assert best.mse < both.mse
    assert ties == ()
    # each is weighed by what is exchanged, though that was not added last
    assert weighed[0] == {*names}


def test_a_strength_at_a_bound_counts_as_one_in_use_unless_it_does_nothing():
    """A zero of the deflection at its bound had passed for an effect without a parameter, the simplest of all."""
    model, problem = problem_of(None, {}, seconds=8.0)
    most = model.with_effect("deflection_zero").bounds("deflection_zero", "x_0")[1]
    for x_0, used in ((0.0, 0), (most, 1)):
        grown = model.with_effect("deflection_zero", {"x_0": x_0})
        fitted = fit(grown, problem, max_iter=0)
        at_bound = np.array([place[0] == "deflection_zero" for place in fitted.free])
        found = cross_judged(("deflection_zero",), replace(fitted, at_bound=at_bound), problem)
        assert complexity(found, problem) == (used, 0)


def test_a_partner_of_a_pair_is_exchanged_for_what_pairs_were_tried_of():
    """No round took it, so that none knows its rivals: both of a pair are held against the best singles."""
    model, problem = problem_of("coulomb_friction", {"F_c": 0.5, "v_0": 0.003}, seed=3)
    drag = 0.05 * problem.scales.force * problem.motion.x / problem.scales.deflection
    problem = replace(problem, force=problem.force + drag * problem.motion.u / 0.3)
    base, catalogue = baseline(model, problem), model.catalogue
    names = ("field_stiffness", "shear_thinning", "coulomb_friction")
    singles = sorted((refit(base, catalogue[n], problem) for n in names), key=lambda c: c.mse)
    step = Round(base, singles, Null(np.zeros(0), 0.0, 1.0, 0.0, np.zeros(0)), 0.02, None, [])
    assert set(partners(step)) == set(names)
    pair = refit(
        singles[[c.name for c in singles].index("field_stiffness")],
        catalogue["shear_thinning"],
        problem,
    )
    best, _ = swapped(pair, [step], problem)
    assert {*best.effects} == {"field_stiffness", "coulomb_friction"}


def test_no_candidate_leaves_less_than_its_own_fit(friction):
    """A gap's fit had ended in a valley; a straight line from there promised less than a brake behind it left."""
    base, (best, other, *_), problem = friction
    null = Null(np.zeros(0), 0.0, 1.0, 0.0, np.zeros(0))
    promised = replace(other, mse=0.5 * best.mse, seen=4.0 * best.left)
    assert promised.left == 4.0 * best.left
    step = decided(base, [promised, best], null, problem, RULE)
    assert step.candidates[0].name == best.name
    assert step.taken.name == best.name


def test_what_is_left_of_a_pair_must_pass_by_itself(friction):
    base, (best, *_), _ = friction
    null = Null(np.zeros(0), 0.0, 1.0, 0.0, np.zeros(0))
    size = effect_size(base, best)
    for limit, taken, left in (
        (2.0 * size, None, base),
        (0.5 * size, None, best),
        (2.0 * size, best, best),
    ):
        assert _standing(best, Round(base, [best], null, limit, taken, [])) is left
    two = replace(best, effects=("coulomb_friction", "stribeck_friction"))
    assert _standing(two, Round(base, [best], null, 2.0 * size, None, [])) is two


def test_errors_of_the_motion_that_are_larger_than_claimed_are_no_bursts():
    _, problem = problem_of(None, {}, seed=6)
    n, rng = problem.motion.n, np.random.default_rng(3)

    def seldom():
        return np.repeat(rng.random(n // 20 + 1) < 0.15, 20)[:n]

    claimed = np.where(seldom(), 0.04, 0.001)
    errors = np.sqrt(0.05**2 + 3.0 * claimed) * rng.standard_normal(n)
    assert bursts(problem, errors, claimed) == 0.0
    elsewhere = errors + 0.4 * seldom() * rng.standard_normal(n)
    assert bursts(problem, elsewhere, claimed) > 0.1


@pytest.mark.parametrize(
    ("sliding", "in_base", "odd"), [(0.0, 0.0, True), (0.5, 0.0, False), (0.0, 0.5, False)]
)
def test_a_breakaway_far_above_the_sliding_friction_stands_for_something_else(
    sliding, in_base, odd
):
    """Unless the friction that it breaks away from is in the model already."""
    values = {"F_c": sliding, "F_s": 2.0, "v_s": 0.03, "v_0": 0.003, "s": 0.0}
    model = load_model(GUO).with_effect("stribeck_friction", values)
    if in_base:
        model = model.with_effect("coulomb_friction", {"F_c": in_base, "v_0": 0.003})
    candidate = SimpleNamespace(name="stribeck_friction", fit=SimpleNamespace(model=model))
    assert strange(candidate) is odd


def test_what_is_beyond_itself_is_taken_only_where_nothing_else_is_there(monkeypatch):
    _alone(monkeypatch)
    monkeypatch.setattr(search, "strange", lambda candidate: candidate.name == "best")
    problem = SimpleNamespace(train=np.ones(GATE.size, bool), cycles=())
    best, next_best = leaving(np.full(GATE.size, 0.5)), leaving(np.full(GATE.size, 1.0))
    best.name, next_best.name = "best", "next"
    null = replace(ERRORS, least=0.0)
    for given, taken in (([best, next_best], next_best), ([best], best)):
        assert search.decided(BEFORE, given, null, problem, RULE).taken is taken
