"""What no known effect explains is described so that its effect can be written: the file to begin with is an effect."""

from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.output.report.page import figures
from er_model_lab.output.report.sections import unexplained
from er_model_lab.residual.unexplained import describe, sentences, skeleton
from er_models.own import effects
from lab_help import problem_of
from report_views import view


@pytest.fixture(scope="module")
def made():
    model, problem = problem_of(None, {}, seconds=40.0)
    return problem, problem.predict(model)


def rest_of(made, force, seed=0):
    """The description of a residual: a force over deflection, velocity, duty and time, and noise."""
    problem, predicted = made
    m = problem.motion
    noise = 0.2 * np.random.default_rng(seed).standard_normal(m.n)
    left = force(m.x, m.v, m.u, np.arange(m.n) * m.dt) + noise
    return describe(replace(problem, force=predicted + left), left)


@pytest.mark.parametrize(
    ("force", "first", "said"),
    [
        (lambda x, v, u, t: 0.5 * np.tanh(v / 3e-3), ("velocity", "odd"), "against the motion"),
        (lambda x, v, u, t: 5.0 * np.abs(v), ("velocity", "even"), "asymmetry"),
        (lambda x, v, u, t: 0.2 * (x / np.std(x)) ** 3, ("deflection", "odd"), "spring"),
        (lambda x, v, u, t: 2.0 * u, ("duty", ""), "over duty"),
    ],
)
def test_the_quantity_and_its_shape_are_named(made, force, first, said):
    rest = rest_of(made, force)
    assert (rest.curves[0].quantity, rest.curves[0].shape) == first
    assert said in sentences(rest)[0]
    assert rest.curves[0].share > 0.3
    assert rest.period is None


def test_noise_alone_depends_on_nothing(made):
    for seed in range(4):
        rest = rest_of(made, lambda x, v, u, t: 0.0 * x, seed)
        assert (rest.curves, rest.pairs, rest.period, rest.lines) == ((), (), None, ())
        assert "no single quantity" in sentences(rest)[0]


def test_a_damping_that_differs_between_a_cold_and_a_warm_run_names_the_temperature(
    made, tmp_path
):
    problem, predicted = made
    theta = np.where(np.arange(problem.motion.n) < problem.motion.n // 2, 0.0, 40.0)
    warm = replace(problem, motion=replace(problem.motion, theta=theta))
    rest = rest_of((warm, predicted), lambda x, v, u, t: 12.0 * v * np.sign(theta - 20.0))
    assert set(rest.pairs[0][:2]) == {"velocity", "temperature"}
    assert sorted(rest.as_json()["arguments"]) == ["theta", "v"]
    path = tmp_path / "warm.py"
    path.write_text(skeleton(rest.as_json()))
    assert effects((path,))["my_effect"].parameters[0].name == "K"


def test_a_product_is_seen_though_neither_factor_alone_explains_it(made):
    rest = rest_of(made, lambda x, v, u, t: 0.4 * x * v / (np.std(x) * np.std(v)))
    assert set(rest.pairs[0][:2]) == {"velocity", "deflection"}
    assert rest.curves == ()
    assert sorted(rest.as_json()["arguments"]) == ["v", "x"]


def test_a_tone_is_found_with_frequency_and_amplitude(made):
    rest = rest_of(made, lambda x, v, u, t: 0.3 * np.sin(2 * np.pi * 49.6 * t))
    frequency, amplitude, _ = rest.lines[0]
    assert frequency == pytest.approx(49.6, abs=0.05)
    assert amplitude == pytest.approx(0.3, rel=0.1)
    assert len(rest.lines) == 1


def test_a_force_periodic_in_the_deflection_is_found_and_its_file_is_a_start(made, tmp_path):
    rest = rest_of(made, lambda x, v, u, t: 0.5 * np.sin(2 * np.pi * x / 4e-3 + 0.5))
    length, amplitude, share = rest.period
    assert length == pytest.approx(4e-3, rel=0.02)
    assert amplitude == pytest.approx(0.5, rel=0.1)
    assert share > 0.6
    path = tmp_path / "my_effect.py"
    path.write_text(skeleton(rest.as_json()))
    effect = effects([path])["my_effect"]
    period = next(p for p in effect.parameters if p.name == "p")
    assert period.starts[0] * made[0].scales.deflection == pytest.approx(length, rel=0.01)
    assert effect.hooks["force"](0.5, 4e-3, 0.5, 1e-3) == pytest.approx(
        0.5 * np.sin(np.pi / 2 + 0.5)
    )


@pytest.mark.parametrize(
    ("force", "names"),
    [
        (lambda x, v, u, t: 0.3 * np.sin(2 * np.pi * 49.6 * t), ["A", "f", "phi"]),
        (lambda x, v, u, t: 20.0 * u * v, ["K"]),
    ],
)
def test_every_file_to_begin_with_is_a_valid_effect(made, tmp_path, force, names):
    path = tmp_path / "my_effect.py"
    path.write_text(skeleton(rest_of(made, force).as_json()))
    assert [p.name for p in effects([path])["my_effect"].parameters] == names


def test_the_page_draws_it_and_gives_the_file(made):
    rest = rest_of(made, lambda x, v, u, t: 0.5 * np.tanh(v / 3e-3)).as_json()
    base = view(unexplained={"rest": rest, "share": 0.5, "depends_on": {}, "line": {}})
    found = unexplained.section(base)
    assert "def force(" in found.facts["skeleton"]
    (drawn,) = (f for f in figures(base) if f.name == "unexplained_shapes")
    assert drawn.panels[0].x.label == "velocity [mm/s]"
    assert np.nanmax(np.abs(drawn.panels[-1].marks[0].z)) > 0.3
