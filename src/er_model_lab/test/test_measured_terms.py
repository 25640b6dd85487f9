"""What no effect explains is learnt as one smooth term: its error falls to the floor, its shape is told, no other is."""

from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline
from er_model_lab.results.terms import note, term_json
from er_model_lab.terms.formula import formula
from er_model_lab.terms.learn import Learnt, learn
from er_model_lab.terms.own_file import own_effect
from er_model_lab.terms.search import Samples, conditioned, refined
from er_model_lab.terms.seen import seen
from er_model_lab.terms.shapes import looks_like
from er_models.own import effects
from lab_help import FORCE_NOISE, problem_of

LIMIT = 0.05
"""Size that chance reaches here [N]."""
HIDDEN = {
    "three": lambda x, v, u: 2.5 * np.tanh(30 * v) * np.sin(400 * x) * u,
    "taper": lambda x, v, u: 1500.0 * v * np.abs(x),
    "thread": lambda x, v, u: 0.6 * np.sin(2 * np.pi * x / 3e-3),
}


def made(hidden, model=None, seed=1, seconds=40.0, sensed=lambda force: force):
    """A problem whose force holds another one that the model does not know."""
    given, problem = problem_of(None, {}, seconds=seconds, seed=seed)
    m, model = problem.motion, model or given
    force = problem.force + (sensed(hidden(m.x, m.v, m.u)) if hidden else 0.0)
    return model, replace(problem, force=force)


@pytest.fixture(scope="module")
def learnt():
    """What is learnt of each hidden force: the problem, and the term beside the model."""
    out = {}
    for kind, hidden in HIDDEN.items():
        model, problem = made(hidden)
        out[kind] = problem, learn(baseline(model, problem), problem, LIMIT)
    return out


@pytest.mark.parametrize("kind", HIDDEN)
def test_the_error_on_a_fresh_record_falls_to_what_the_true_model_leaves(kind, learnt):
    _, found = learnt[kind]
    assert isinstance(found, Learnt), found
    model, fresh = made(HIDDEN[kind], seed=7)
    before, after = (
        float(np.sqrt(np.mean((fresh.force - fresh.predict(m))[fresh.used] ** 2)))
        for m in (model, found.model)
    )
    assert before > 1.5 * FORCE_NOISE
    assert after < 1.15 * FORCE_NOISE


def test_the_term_depends_on_what_the_force_does(learnt):
    names = {kind: found.term.name for kind, (_, found) in learnt.items()}
    assert names == {
        "three": "measured_velocity_deflection_duty", "taper": "measured_velocity_deflection",
        "thread": "measured_deflection",
    }  # fmt: skip
    assert learnt["taper"][1].term.shape == ("odd",)
    assert learnt["thread"][1].term.shape == ("odd",)
    assert learnt["three"][1].term.shape == ("even",)


def test_what_the_term_adds_is_what_its_splines_say(learnt):
    problem, found = learnt["three"]
    added = problem.predict(found.model) - problem.predict(replace(found.model, terms=()))
    np.testing.assert_allclose(added, found.force, atol=1e-6 * np.abs(found.force).max())


def test_blocks_left_out_tell_the_error_of_fresh_data(learnt):
    for kind, (_, found) in learnt.items():
        assert np.sqrt(found.candidate.mse) == pytest.approx(FORCE_NOISE, rel=0.1), kind
        sd = np.array(found.term.deviations)
        assert np.all(sd >= 0.0) and np.median(sd) > 0.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_complete_model_gets_no_term(seed):
    model, problem = made(None, seed=seed, seconds=24.0)
    said = learn(baseline(model, problem), problem, 0.12 * FORCE_NOISE)
    assert isinstance(said, str) and "not added" in said


def test_the_formula_is_the_hidden_force_and_begins_an_effect(learnt, tmp_path):
    problem, found = learnt["taper"]
    written = formula(found, problem)
    assert [[p.words for p in b] for b in written.blocks] == [["v", "|x|"]]
    assert written.share == pytest.approx(1.0 - found.candidate.mse / found.before.mse, rel=0.02)
    file = tmp_path / "taper.py"
    file.write_text(own_effect(written, found.term.name, problem.scales), encoding="utf-8")
    effect = effects([file])["my_measured_velocity_deflection"]  # passes `own_check`
    (k,) = effect.parameters
    strength = k.starts[0] * problem.scales.of(k.unit)
    assert effect.hooks["force"](strength, -0.1, -0.004) == pytest.approx(-0.6, rel=0.1)
    assert effect.hooks["force"](0.0, 0.1, 0.004) == 0.0


def test_a_lagged_formula_is_an_effect_with_a_state(learnt, tmp_path):
    from er_model_lab.terms.formula import Formula, Power

    problem, _ = learnt["taper"]
    blocks = ((Power("w", 1, odd=True), Power("u", 1, odd=True)), (Power("v", 0, odd=True),))
    blocks += ((Power("x", 2, odd=True),), (Power("a", 1, odd=False),))
    units = {"v": 0.1, "w": 0.1, "x": 0.01, "a": 2.0, "u": 0.3}
    written = Formula(blocks, (1.0, -2.0, 0.5, 0.1), 0.9, units, lag=0.02)
    file = tmp_path / "lagged.py"
    file.write_text(own_effect(written, "measured_velocity_lagged", problem.scales))
    effect = effects([file])["my_measured_velocity_lagged"]
    assert effect.has_state
    force = effect.hooks["force"](1.0, -2.0, 0.5, 0.1, w=0.05, u=0.3, v=0.1, x=-0.02, a=-4.0)
    assert force == pytest.approx(0.5 - 2.0 - 2.0 + 0.2)
    assert "w" in written.text and "x |x|" in written.text


def test_the_shape_of_an_effect_that_was_left_out_is_told():
    model, problem = problem_of("quadratic_damping", {"c_2": 120.0}, seconds=24.0)
    found = learn(baseline(model, problem), problem, LIMIT)
    assert isinstance(found, Learnt)
    near = looks_like(found, problem)
    assert near[0]["effect"] == "quadratic_damping"
    assert near[0]["correlation"] > 0.97


def test_all_that_is_said_of_it_is_plain_and_labelled(learnt):
    problem, found = learnt["taper"]
    entry = term_json(found, problem)
    assert entry["label"] == "measured, not explained"
    assert entry["rmse_held_out"]["after"] < 0.6 * entry["rmse_held_out"]["before"]
    assert "measured, not explained" in note(entry)
    assert "v |x|" in note(entry)


def test_a_sensor_that_lags_shows_the_term_late():
    def late(force):
        from scipy.signal import lfilter

        c = np.exp(-0.005 / 0.02)
        return np.asarray(lfilter([1.0 - c], [1.0, -c], force))

    given, _ = problem_of(None, {}, seconds=1.5)
    model = given.with_effect("force_lag", {"T_F": 0.02})
    _, problem = made(None)
    m = problem.motion
    bare = problem.predict(model)
    noise = problem.force - problem.predict(given)
    problem = replace(problem, force=bare + noise + late(HIDDEN["taper"](m.x, m.v, m.u)))
    found = learn(baseline(model, problem), problem, LIMIT)
    assert isinstance(found, Learnt), found
    assert np.sqrt(found.candidate.mse) < 1.1 * FORCE_NOISE
    added = problem.predict(found.model) - problem.predict(replace(found.model, terms=()))
    np.testing.assert_allclose(added, found.force, atol=0.02 * np.abs(found.force).max())


def test_quantities_are_what_the_kernel_sees():
    model, problem = made(None, seconds=6.0)
    values, m = seen(model, problem), problem.motion
    np.testing.assert_allclose(values["velocity"], m.v, atol=1e-8)
    np.testing.assert_allclose(values["duty"], m.u, atol=1e-8)
    assert "temperature" not in values  # it does not change
    late = seen(model, problem, [("velocity_lagged", 0.05)])["velocity_lagged"]
    assert 0.5 < np.std(late) / np.std(m.v) < 0.95


def samples(force, n=4000):
    """Values at random and a force over them, with noise."""
    rng = np.random.default_rng(0)
    v, x = rng.uniform(-1.0, 1.0, (2, n))
    left = force(v, x) + 0.1 * rng.standard_normal(n)
    return Samples({"velocity": v, "deflection": x}, np.empty((n, 0)), left, np.arange(n) * 12 // n)


@pytest.mark.parametrize(
    ("force", "quantities", "shape"),
    [
        (lambda v, x: np.tanh(3 * v), ("velocity",), ("odd", "rising with velocity")),
        (lambda v, x: -np.tanh(3 * v), ("velocity",), ("odd", "falling with velocity")),
        (lambda v, x: np.sin(4 * v) * np.abs(v), ("velocity",), ("odd",)),
        (lambda v, x: np.sin(2.8 * v), ("velocity",), ("odd", "dissipative")),
        (lambda v, x: np.cos(3 * v), ("velocity",), ("even",)),
        (lambda v, x: np.exp(v), ("velocity",), ("rising with velocity",)),
        (lambda v, x: v * (1.0 + np.sin(3 * x)) ** 2, ("velocity", "deflection"), ("rising with velocity",)),
    ],
)  # fmt: skip
def test_symmetry_and_sign_are_kept_where_the_data_say_so(force, quantities, shape):
    given = samples(force)
    base = float(np.mean(given.left**2))
    found = conditioned(refined((quantities, ""), given, base), given, base)
    assert found.shape == shape
    own = given.normal(found.design(given.values)).through(found.map)
    z = own.solved(found.penalty(own))
    if found.held is not None:
        assert np.min(found.held @ found.map @ z) > -1e-2
    left = given.left - found.design(given.values) @ found.map @ z
    assert np.std(left) < 0.106
