"""What no effect explains is learnt as one smooth term: the error falls to the floor, and its shape is told."""

from dataclasses import replace
from io import StringIO
from types import SimpleNamespace

import numpy as np
import pytest
from er_model_lab.cli.missing import _with_effect_files
from er_model_lab.cli.options import worded
from er_model_lab.diagnosis.candidates import baseline
from er_model_lab.level.damper import DamperLevel
from er_model_lab.output.report.page import write_report
from er_model_lab.output.report.sections.measured_terms import section
from er_model_lab.output.terminal.summary import summary
from er_model_lab.results.result import with_notes
from er_model_lab.results.terms import note, term_json
from er_model_lab.terms.formula import formula
from er_model_lab.terms.learn import Learnt, _refused, learn
from er_model_lab.terms.own_file import own_effect
from er_model_lab.terms.regression import normal
from er_model_lab.terms.search import Samples, conditioned, refined
from er_model_lab.terms.seen import seen
from er_model_lab.terms.shapes import looks_like
from er_model_lab.verbs.compare import compare
from er_model_lab.verbs.diagnose import offer
from er_model_lab.verbs.improve import improve
from er_models.errors import InputError
from er_models.files import load_model, save_model
from er_models.own import effects
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import FORCE_NOISE, GUO, problem_of
from rich.console import Console

pytestmark = pytest.mark.slow

LIMIT = 0.05
"""Size that chance reaches here [N]."""
HIDDEN = {
    "three": lambda x, v, u: 2.5 * np.tanh(30 * v) * np.sin(400 * x) * u,
    "taper": lambda x, v, u: 1500.0 * v * np.abs(x),
    "thread": lambda x, v, u: 0.6 * np.sin(2 * np.pi * x / 3e-3),
}


def made(hidden, seed=1, seconds=16.0):
    """A problem whose force holds another one that the model does not know."""
    model, problem = problem_of(None, {}, seconds=seconds, seed=seed)
    m = problem.motion
    force = problem.force + (hidden(m.x, m.v, m.u) if hidden else 0.0)
    return model, replace(problem, force=force)


def added(problem, found):
    """What the term adds to the force of the model, and what its splines say, of the samples that count.

    Before them unknown states fade, which the term changes.
    """
    with_it, without = (problem.predict(m) for m in (found.model, replace(found.model, terms=())))
    return (with_it - without)[problem.used], found.force[problem.used]


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
    np.testing.assert_allclose(*added(problem, found), atol=1e-9 * np.abs(found.force).max())


def test_blocks_left_out_tell_the_error_of_fresh_data(learnt):
    for kind, (_, found) in learnt.items():
        assert np.sqrt(found.candidate.mse) == pytest.approx(FORCE_NOISE, rel=0.1), kind
        sd = np.array(found.term.deviations)
        assert np.all(sd >= 0.0)
        assert np.median(sd) > 0.0


def test_two_forces_over_different_quantities_are_two_terms(tmp_path):
    def both(x, v, u):
        return 1500.0 * v * np.abs(x) + np.sin(10.0 * u)

    model, problem = made(both, seconds=40.0)  # long enough to hold out no level of the duty whole
    first = learn(baseline(model, problem), problem, LIMIT)
    second = learn(first.candidate, problem, LIMIT)
    assert isinstance(second, Learnt), second
    assert len({t.name for t in second.model.terms}) == 2
    assert second.model.terms[0] == first.term
    fresh = made(both, seed=7)[1]
    left = [
        float(np.std((fresh.force - fresh.predict(t.model))[fresh.used])) for t in (first, second)
    ]
    assert left[1] < min(0.6 * left[0], 1.2 * FORCE_NOISE)
    save_model(second.model, tmp_path / "two.yaml")
    again = problem.predict(load_model(tmp_path / "two.yaml"))
    np.testing.assert_allclose(again, problem.predict(second.model), atol=1e-9)
    assert "no further term" in learn(second.candidate, problem, LIMIT)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_complete_model_gets_no_term(seed):
    model, problem = made(None, seed=seed)
    said = learn(baseline(model, problem), problem, 0.12 * FORCE_NOISE)
    assert isinstance(said, str)
    assert "not added" in said


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
    assert "w" in written.text
    assert "x |x|" in written.text


def test_the_shape_of_an_effect_that_was_left_out_is_told():
    model, problem = problem_of("quadratic_damping", {"c_2": 120.0}, seconds=16.0)
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

    given, problem = made(None)
    model = given.with_effect("force_lag", {"T_f": 0.02})
    m = problem.motion
    bare = problem.predict(model)
    noise = problem.force - problem.predict(given)
    problem = replace(problem, force=bare + noise + late(HIDDEN["taper"](m.x, m.v, m.u)))
    found = learn(baseline(model, problem), problem, LIMIT)
    assert isinstance(found, Learnt), found
    assert np.sqrt(found.candidate.mse) < 1.1 * FORCE_NOISE
    np.testing.assert_allclose(*added(problem, found), atol=0.02 * np.abs(found.force).max())


def test_quantities_are_what_the_kernel_sees():
    model, problem = made(None, seconds=6.0)
    values, m, used = seen(model, problem), problem.motion, problem.used
    np.testing.assert_allclose(values["velocity"][used], m.v[used], atol=1e-8)
    np.testing.assert_allclose(values["duty"][used], m.u[used], atol=1e-8)
    assert "temperature" not in values  # it does not change
    late = seen(model, problem, [("velocity_lagged", 0.05)])["velocity_lagged"]
    assert 0.5 < np.std(late) / np.std(m.v) < 0.95


def samples(force, n=4000):
    """Values at random and a force over them, with noise."""
    rng = np.random.default_rng(0)
    v, x = rng.uniform(-1.0, 1.0, (2, n))
    left = force(v, x) + 0.1 * rng.standard_normal(n)
    return Samples(
        {"velocity": v, "deflection": x}, np.empty((n, 0)), left, np.arange(n) * 12 // n
    )


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


@pytest.fixture(scope="module")
def improved():
    """`improve` of a model that lacks a force outside of the catalogue, and what was known of it before."""
    data = [data_of(HIDDEN["three"], seed) for seed in (1, 2, 3)]
    return improve(Dataset.of(data), load_model(GUO), measured_terms=True)


def data_of(hidden, seed, seconds=6.0):
    """A record of the force of the model and a hidden one."""
    _, problem = made(hidden, seed=seed, seconds=seconds)
    m, t = problem.motion, np.arange(problem.motion.n) * problem.motion.dt
    channels = {
        "deflection": m.x, "deflection_velocity": m.v, "duty": m.u, "damper_force": problem.force,
        "sprung_acceleration": m.a, "unsprung_acceleration": 0.0 * m.a,
    }  # fmt: skip
    return Record(f"run{seed}", t, channels)


def test_improve_learns_it_and_says_what_it_is(improved, tmp_path):
    told = improved.to_dict()
    (term,) = improved.model.terms
    (entry,) = told["measured_terms"]
    assert entry["name"] == term.name == "measured_velocity_deflection_duty"
    assert told["verdict"] == "unknown_effect"
    assert told["effects"][-1] == told["steps"][-1]["added"] == term.name
    assert told["rmse_after"]["held_out"] == entry["rmse_held_out"]["after"]
    assert entry["rmse_held_out"]["after"] < 1.15 * FORCE_NOISE
    assert improved.model.history[-1]["added"] == [term.name]
    assert {"looks_like", "formula", "effect_source", "effect_file"} <= entry.keys()
    assert not any("measured_terms=True" in note for note in told["notes"])
    save_model(improved.model, tmp_path / "better.yaml")
    again = compare(
        Dataset.of([data_of(HIDDEN["three"], 9)]), load_model(tmp_path / "better.yaml")
    )
    assert again.rmse < 1.15 * FORCE_NOISE
    assert not any("held constant" in note for note in again.to_dict()["notes"])
    low = tuple(tuple(0.3 * k for k in knots) for knots in term.knots)
    narrow = replace(improved.model, terms=(replace(term, knots=low),))
    beyond = compare(Dataset.of([data_of(HIDDEN["three"], 9)]), narrow)
    assert any(f"{term.name} is held constant in" in note for note in beyond.to_dict()["notes"])


def test_an_offer_is_the_last_note(improved):
    before = improved.to_dict()["notes"]
    assert with_notes(improved, "first", last=("last",)).to_dict()["notes"] == [
        "first",
        *before,
        "last",
    ]


def test_what_is_left_is_offered_to_be_learnt(improved):
    asked = SimpleNamespace(level=DamperLevel(), model=load_model(GUO))
    for verdict in ("unknown_effect", "partial", "adequate"):
        content = dict(improved.view.result) | {"verdict": verdict, "final_verdict": verdict}
        view = replace(improved.view, result=content)
        said = " ".join(offer(replace(improved, view=view), asked))
        assert ("measured_terms=True" in said) == (verdict != "adequate")
        assert ("--measured-terms" in worded(said)) == (verdict != "adequate")


def test_it_is_refused_where_chance_a_few_blocks_or_held_out_data_speak_against_it(learnt):
    problem, found = learnt["taper"]
    before, after = found.before, found.candidate
    assert _refused(before, after, problem, LIMIT) == ""
    assert "chance reaches" in _refused(before, after, problem, 10.0)
    worse = after.fit.residual + 3.0 * problem.held_out * FORCE_NOISE
    bad = replace(after, fit=replace(after.fit, residual=worse))
    assert "held-out data would rise" in _refused(before, bad, problem, LIMIT)
    uneven = before.losses * (1.0 - 0.9 * (np.arange(before.losses.size) == 3)) - 1e-9
    assert _refused(before, replace(after, losses=uneven), problem, LIMIT) == ""
    losses = after.losses.copy()
    losses[0] = 20.0 * before.losses[0]
    assert "varies too much" in _refused(before, replace(after, losses=losses), problem, LIMIT)


def test_a_block_is_judged_by_those_that_are_no_neighbours_of_it():
    rng = np.random.default_rng(0)
    d, block = rng.normal(size=(120, 3)), np.arange(120) // 10
    r = rng.normal(size=120)
    made_of = normal(np.empty((120, 0)), d, r, block)
    without = made_of.left_out(np.zeros((3, 3)))
    for b in (0, 5):
        others = np.abs(block - b) > 1
        np.testing.assert_allclose(without[b], np.linalg.lstsq(d[others], r[others])[0])
    left = [np.mean((r - d @ without[b])[block == b] ** 2) for b in range(12)]
    np.testing.assert_allclose(made_of.judged(np.zeros((3, 3))), left)


def test_the_command_writes_the_formula_beside_the_model(improved, tmp_path):
    told = _with_effect_files(improved, tmp_path / "better.yaml").to_dict()
    file = tmp_path / "better.measured_velocity_deflection_duty.py"
    assert told["measured_terms"][0]["effect_file"] == str(file)
    assert "my_measured_velocity_deflection_duty" in effects([file]).names


def test_terminal_and_report_carry_the_label(improved, tmp_path):
    console = Console(width=100, file=StringIO())
    console.print(summary(improved.view))
    assert "Measured, not explained: with a smooth term" in console.file.getvalue()
    page = write_report(improved.view, tmp_path, (section(improved.view),)).read_text(
        encoding="utf-8"
    )
    assert "What was learnt: measured, not explained" in page
    assert "not why it is there" in page


def test_a_term_is_learnt_of_a_damper_alone():
    with pytest.raises(InputError, match="damper"):
        improve(
            Dataset.of([data_of(None, 1)]), load_model(GUO), level="vehicle", measured_terms=True
        )
