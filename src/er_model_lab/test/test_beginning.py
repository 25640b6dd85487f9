"""Where the states of a record begin: the measured force says it, and nothing is assumed. Own small equations."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline, effect_size, refit
from er_model_lab.problem.prepare import prepare
from er_models.files import load_model
from er_models.prediction import Told, beginnings, caught, motion, predict, substeps
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import DT, FORCE_NOISE, GUO, imposed

FINE = 20
"""Steps of the tests' own equations in a sample."""
PASSIVE = 300.0
"""Damping beside the hidden element [N s/m]."""


def at_rest_first(v, x, seconds):
    """A motion that begins at rest and is let go within half a second; deflection, velocity, acceleration."""
    t = np.arange(v.size) * DT
    gate = np.clip((t - seconds) / 0.5, 0.0, 1.0)
    smooth = gate**3 * (10.0 - 15.0 * gate + 6.0 * gate**2)
    moved = (x - x[0]) * smooth
    return moved, np.gradient(moved, DT), np.gradient(np.gradient(moved, DT), DT)


def relaxed(v, rate, drive, w):
    """A state w' = drive(v) - rate(v) w at the samples, from the value w, by short explicit steps."""
    out = np.empty(v.size)
    for k in range(v.size):
        out[k] = w
        after = v[min(k + 1, v.size - 1)]
        for j in range(FINE):
            here = v[k] + (j + 0.5) / FINE * (after - v[k])
            w += DT / FINE * (drive(here) - rate(here) * w)
    return out


def measured(rng, x, v, a, force):
    """One record with the noise of the sensors."""
    n = x.size
    return Record("made", np.arange(n) * DT, {
        "deflection": x + 2e-5 * rng.standard_normal(n),
        "deflection_velocity": v + 1e-3 * rng.standard_normal(n),
        "duty": np.zeros(n),
        "sprung_acceleration": a + 0.025 * rng.standard_normal(n),
        "unsprung_acceleration": 0.025 * rng.standard_normal(n),
        "damper_force": force + FORCE_NOISE * rng.standard_normal(n),
    })  # fmt: skip


def dahl(rng, n=3200):
    """A damper with a Dahl element, from rest with its spring unbent."""
    x, v, a, _ = imposed(rng, n)
    x, v, a = at_rest_first(v, x, 1.0)
    z_y = 1e-3
    z = relaxed(v, lambda y: abs(y) / z_y, lambda y: y, 0.0)
    return measured(rng, x, v, a, PASSIVE * v + 20.0 * z / z_y)


def maxwell(rng, n=3200):
    """A damper with a Maxwell branch, from the middle of a motion."""
    x, v, a, _ = imposed(rng, n + 600)
    f = relaxed(v, lambda _: 1.0 / 0.6, lambda y: 4000.0 * y, 0.0)
    record = measured(rng, x, v, a, PASSIVE * v + f)
    return record.slice(600, n + 600)


TWINS = {"bouc_wen_hysteresis": dahl, "viscoelastic_branch": maxwell}


def grown(effect, records=4):
    """A problem whose records hold an effect, the model without it, and with it, fitted."""
    rng = np.random.default_rng(3)
    problem = prepare(Dataset.of([TWINS[effect](rng) for _ in range(records)]))
    base = baseline(load_model(GUO), problem)
    return problem, base, refit(base, base.fit.model.catalogue[effect], problem, max_iter=30)


@pytest.mark.parametrize("effect", TWINS)
def test_an_effect_whose_state_begins_anywhere_leaves_the_noise(effect):
    problem, _, found = grown(effect)
    square, late = found.fit.residual**2, problem.held_out & (problem.motion.t > 5.0)
    left = np.sqrt(np.mean(square[problem.held_out]))
    assert left < 1.05 * np.sqrt(np.mean(square[late]))  # where any beginning is forgotten
    assert max(left, np.sqrt(found.mse)) < 1.25 * FORCE_NOISE  # errors of the motion add a fifth


@pytest.mark.parametrize("effect", TWINS)
def test_the_beginnings_of_records_are_counted(effect):
    problem, base, found = grown(effect, records=3)
    told = problem.forward.beginnings(problem, found.fit.model)
    assert 0.5 < told - problem.forward.beginnings(problem, base.fit.model) <= 3.0


def test_held_out_samples_of_a_record_that_is_learnt_from_do_not_tell():
    problem = prepare(Dataset.of([maxwell(np.random.default_rng(0))]))
    later = problem.held_out & (problem.motion.t > 1.0)
    assert later.any()
    assert not problem.told.weight[later].any()


def test_a_force_that_tells_nothing_leaves_the_old_rule():
    x, v, a, u = imposed(np.random.default_rng(0), 800)
    inputs, model = motion(DT, x, v, u, a), load_model(GUO).with_effect("viscoelastic_branch")
    nothing = Told(np.zeros(800), np.zeros(800), 60)
    np.testing.assert_allclose(
        predict(model, inputs, nothing), predict(model, inputs), rtol=0, atol=1e-12
    )
    assert beginnings(model, inputs, nothing) == 0.0


def test_a_beginning_is_found_to_the_last_digits_where_there_is_no_noise():
    """The middle of a motion, predicted from its beginning on, is predicted from the middle on."""
    x, v, a, u = imposed(np.random.default_rng(0), 2400)
    model = load_model(GUO).with_effect("viscoelastic_branch")
    model = model.with_effect("viscoelastic_branch", {"k_m": 4000.0, "t_m": 0.3})
    whole = predict(model, motion(DT, x, v, u, a))[400:]
    part = motion(DT, x[400:], v[400:], u[400:], a[400:])
    told = Told(whole, np.full(2000, 1e6), 60)
    assumed, found = predict(model, part) - whole, predict(model, part, told) - whole
    assert np.abs(assumed).max() > 1.0
    assert np.abs(found[60:]).max() < 0.01 * np.abs(assumed).max()


def test_a_complete_model_from_rest_stays_complete():
    """Beginnings of their own are no gain: neither effect reaches what counts as one (0.12 of the noise)."""
    rng = np.random.default_rng(5)
    x, v, a = at_rest_first(*imposed(rng, 3200)[1::-1], 1.0)
    records = [measured(rng, x, v, a, PASSIVE * v) for _ in range(4)]
    problem = prepare(Dataset.of(records))
    base = baseline(load_model(GUO), problem)
    for effect in TWINS:
        found = refit(base, base.fit.model.catalogue[effect], problem)
        assert effect_size(base, found) < 0.12 * FORCE_NOISE


def test_beginnings_cost_few_steps():
    """They need two more runs of one step a sample, up to where the force shows nothing of them any more."""
    problem, _, found = grown("viscoelastic_branch")
    model, inputs = found.fit.model, problem.motion
    moved = predict(model, inputs, problem.told) != predict(model, inputs)
    shown = [np.flatnonzero(moved[i:j])[-1] + 1 for i, j in itertools.pairwise(inputs.starts)]
    assert min(shown) > 1.0 / DT
    assert 2 * sum(shown) < 0.3 * inputs.n * substeps(DT)


@pytest.mark.parametrize(("before", "later"), [(0.1, 1.6), (0.45, 1.6), (0.3, 1.6), (0.45, 1.0)])
def test_a_field_that_stayed_from_before_the_record_is_found(before, later):
    """The play of the field stands where an earlier duty left it; small steps do not move it for seconds.

    What left it there may be more than the record ever has again.
    """
    x, v, a, _ = imposed(np.random.default_rng(0), 2400)
    level = np.random.default_rng(1).uniform(0.22, 0.34, 24)
    level[:2], level[14:] = (before, 0.28), later * level[14:]
    u = np.repeat(level, 100)
    model = load_model(GUO).with_effect("remanence", {"r": 0.1, "s": 0.7})
    whole = predict(model, motion(DT, x, v, u, a))[150:]
    part = motion(DT, x[150:], v[150:], u[150:], a[150:])
    found = predict(model, part, Told(whole, np.full(part.n, 1e4), 60)) - whole
    assumed = predict(model, part) - whole
    assert np.abs(assumed).max() > 1.0
    assert np.std(found) < 0.2 * np.std(assumed)


def test_an_offset_of_a_record_of_one_duty_is_no_field_that_stayed():
    """Runs of a steady current differ by whatever an offset may stand for; what drags the field never moves there."""
    x, v, a, _ = imposed(np.random.default_rng(5), 1600)
    model = load_model(GUO).with_effect("remanence", {"r": 0.1, "s": 0.7})
    rng = np.random.default_rng(1)
    steady = motion(DT, x, v, 0.25 + 1e-4 * rng.standard_normal(1600), a)
    told = predict(load_model(GUO), motion(DT, x, v, np.full(1600, 0.3), a))
    assumed = predict(model, steady)
    assert np.abs(told - assumed).max() > 1.0
    found = predict(model, steady, Told(told, np.full(1600, 1e4), 60))
    assert found == pytest.approx(assumed, abs=1e-2)


@pytest.mark.parametrize("stop", [300, 420, 555])
def test_a_worn_joint_that_rests_in_its_gap_is_found_there(stop):
    """Friction holds the damper wherever the motion ended; nothing shows of it until the joint closes."""
    x, v, a, u = imposed(np.random.default_rng(0), 2400)
    gate = np.clip(np.abs(np.arange(2400) - stop - 50) / 50.0 - 1.0, 0.0, 1.0) ** 3
    x = x * gate
    v, a = np.gradient(x, DT), np.gradient(np.gradient(x, DT), DT)
    bare = load_model(GUO).without_effect("guo_yield").without_effect("response")
    model = bare.with_effect("passive", {"k0": 2000.0, "c0": 300.0})
    model = model.with_effect("coulomb_friction", {"F_c": 40.0, "v_0": 0.003})
    model = model.with_effect("freeplay", {"b": 0.002, "q": 1e-6})
    begun = stop + 50
    whole = predict(model, motion(DT, x, v, u, a))[begun:]
    part = motion(DT, x[begun:], v[begun:], u[begun:], a[begun:])
    found = predict(model, part, Told(whole, np.full(part.n, 1e2), 60)) - whole
    assumed = predict(model, part) - whole
    assert np.abs(assumed).max() > 1.0
    assert np.std(found) < 0.2 * np.std(assumed)


def test_what_was_caught_is_found_again_near_where_it_was():
    """A look for where friction in its play begins takes ten runs of each record; models nearby are spared them."""
    x, v, a, u = imposed(np.random.default_rng(0), 2400)
    friction = {"F_h": 30.0, "F_u": 0.0, "z_y": 5e-4, "b": 1.5e-3}
    model = load_model(GUO).with_effect("friction_with_play", friction)
    whole = predict(model, motion(DT, x, v, u, a))[700:]
    part = motion(DT, x[700:], v[700:], u[700:], a[700:])
    told = Told(whole, np.full(part.n, 1e2), 60)
    force, known = caught(model, part, told)
    assert np.array_equal(force, predict(model, part, told))
    assert np.isfinite(known).sum() == 1
    assert caught(model.without_effect("friction_with_play"), part, told) is None
    hinted = replace(told, caught=known)
    assert caught(model, part, hinted) is None
    assumed, size = predict(model, part), 0.01
    for near in (model, model.with_effect("friction_with_play", friction | {"z_y": 5.2e-4})):
        looked = predict(near, part, told)
        assert np.std(assumed - looked) > 10.0 * size
        assert np.std(predict(near, part, hinted) - looked) < size
    # where the hint is wrong it is followed all the same: nothing is looked for
    wrong = replace(told, caught=np.where(np.isfinite(known), -known, known))
    assert np.std(predict(model, part, wrong) - predict(model, part, told)) > size


@pytest.mark.parametrize("steep", [500.0, 5000.0])
@pytest.mark.parametrize("beside", [{}, {"remanence": {"r": 0.23, "s": 0.8}}])
def test_where_a_beginning_is_looked_for_the_prediction_keeps_its_numbers(steep, beside):
    """Looks far aside end beyond all measure where a joint feels a damping far above the fluid's, and where a field
    that stayed makes it negative; nothing of that may reach what is predicted."""
    x, v, a, u = imposed(np.random.default_rng(4), 800)
    u = np.where(np.arange(800) < 300, 0.0, 0.9)  # nothing of the field yet, where it begins
    model = load_model(GUO).with_effect("field_viscosity", {"c_u": steep})
    model = model.with_effect("freeplay", {"b": 2.5e-4, "q": 1e-8})
    for name, values in beside.items():
        model = model.with_effect(name, values)
    along = motion(DT, x, v, u, a)
    assumed = predict(model, along)
    assert np.isfinite(assumed).all()
    found = predict(model, along, Told(assumed, np.full(along.n, 1e2), 60))
    assert found == pytest.approx(assumed, abs=0.05 * np.abs(assumed).max())


REST = 600
"""Samples of a rest, three seconds."""


@pytest.fixture
def rested():
    """A motion that ends in the middle, rests, and goes on: motion, duty, and where it goes on."""
    x, v, a, u = imposed(np.random.default_rng(3), 2400)
    stop = int(np.argmin(np.abs(v[400:600]))) + 400
    held = np.concatenate([np.arange(stop), np.full(REST, stop), np.arange(stop, 2400)])
    still = slice(stop, stop + REST)
    x, v, a, u = x[held], v[held], a[held], u[held]
    v[still] = a[still] = 0.0
    return (x, v, a, u), stop + REST


def test_a_rest_at_the_beginning_tells_no_more_the_longer_it_lasts(rested):
    (x, v, a, u), go = rested
    friction = {"F_h": 30.0, "F_u": 0.0, "z_y": 5e-4, "b": 1.5e-3}
    model = load_model(GUO).with_effect("friction_with_play", friction)
    whole = predict(model, motion(DT, x, v, u, a))
    found = {}
    for rest in (40, REST - 50):
        part = slice(go - rest, None)
        here = motion(DT, x[part], v[part], u[part], a[part])
        assumed = predict(model, here)
        assert np.abs(assumed - whole[part]).max() > 0.5
        found[rest] = predict(model, here, Told(whole[part], np.full(here.n, 1e2), 60))
        assert np.std(found[rest] - whole[part]) < 0.2 * np.std(assumed - whole[part])
    longer, shorter = found[REST - 50][-(found[40].size) :], found[40]
    assert np.std(longer - shorter) < 0.05 * np.std(assumed[-shorter.size :] - shorter)
