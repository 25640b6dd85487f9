"""A measured term is what SciPy makes of its splines, stands whole in the model file, and ends where it was learnt."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from er_models.errors import InputError
from er_models.files import load_model, save_model
from er_models.measured import MeasuredTerm
from er_models.model import Array, Model
from er_models.prediction import Motion, motion, predict
from er_models.static_damper import static_damper
from models_help import guo
from scipy.interpolate import BSpline

V_KNOTS = (-0.06,) * 4 + (-0.03, 0.0, 0.01) + (0.07,) * 4
X_KNOTS = (-5e-3,) * 4 + (0.0, 2e-3) + (6e-3,) * 4
C = np.random.default_rng(0).normal(size=(7, 6))


def moved() -> Motion:
    dt = 1e-3
    t = np.arange(1500) * dt
    x = 8e-3 * np.sin(9 * t) + 1e-3 * np.sin(31 * t)
    v = np.gradient(x, dt)
    return motion(dt, x, v, 0.1 + 0.1 * np.sin(3 * t))


def spline(values: Array, knots: tuple[float, ...]) -> Array:
    inside = np.clip(values, knots[0], knots[-1])
    return np.asarray(BSpline.design_matrix(inside, np.array(knots), 3).toarray())


def with_term(*terms: MeasuredTerm) -> Model:
    return replace(guo(), terms=terms)


def plane(**more: object) -> MeasuredTerm:
    sd = tuple(np.abs(C.ravel()))
    made = MeasuredTerm(("velocity", "deflection"), (V_KNOTS, X_KNOTS), tuple(C.ravel()), sd)
    return replace(made, **more)  # type: ignore[arg-type]


def line(quantity: str, slope: float = 1.0, lag: float = 0.0) -> MeasuredTerm:
    """A term in proportion to a quantity."""
    c = tuple(slope * k for k in (-1e3, -1e3 / 3, 1e3 / 3, 1e3))
    return MeasuredTerm((quantity,), ((-1e3,) * 4 + (1e3,) * 4,), c, (0.0,) * 4, lag=lag)


@pytest.mark.parametrize("times", ["", "duty"])
def test_the_kernel_adds_what_scipy_makes_of_the_splines(times: str) -> None:
    m = moved()
    added = predict(with_term(plane(times=times)), m) - predict(guo(), m)
    want = np.einsum("ni,nj,ij->n", spline(m.v, V_KNOTS), spline(m.x, X_KNOTS), C)
    want = want * m.u if times else want
    assert np.abs(added - want).max() < 1e-12 * np.abs(want).max() + 1e-14
    outside = (m.v > V_KNOTS[-1]) | (m.x > X_KNOTS[-1])
    assert outside.any()
    assert not outside.all()


def test_several_terms_add_up() -> None:
    m = moved()
    single = MeasuredTerm(("deflection",), (X_KNOTS,), tuple(C[0]), (0.0,) * 6)
    base, both = predict(guo(), m), predict(with_term(single, plane()), m)
    apart = [predict(with_term(t), m) - base for t in (single, plane())]
    np.testing.assert_allclose(both - base, sum(apart), atol=1e-12)
    np.testing.assert_allclose(apart[0], spline(m.x, X_KNOTS) @ C[0], atol=1e-13)


@pytest.mark.parametrize(
    ("quantity", "values"),
    [("deflection", "x"), ("velocity", "v"), ("acceleration", "a"), ("duty", "u")],
)
def test_a_term_sees_the_signal_of_its_quantity(quantity: str, values: str) -> None:
    m = moved()
    added = predict(with_term(line(quantity)), m) - predict(guo(), m)
    np.testing.assert_allclose(added, getattr(m, values), atol=1e-9)


def test_a_term_sees_the_force_and_what_is_lagged() -> None:
    m, base = moved(), predict(guo(), moved())
    np.testing.assert_allclose(predict(with_term(line("force")), m), 2.0 * base, atol=1e-9)
    lagged = predict(with_term(line("velocity_lagged", lag=0.05)), m) - base
    w, share = np.empty(m.n), np.exp(-m.dt / 0.05)
    w[0] = m.v[0]
    for k in range(1, m.n):  # exact for a velocity that is straight between samples
        rise = m.v[k] - m.v[k - 1]
        w[k] = m.v[k] - rise * 0.05 / m.dt * (1 - share) + (w[k - 1] - m.v[k - 1]) * share
    np.testing.assert_allclose(lagged, w, atol=2e-5)
    formed = predict(with_term(line("formed_duty")), m) - base
    assert 1e-3 < np.abs(formed - m.u).max() < 0.1


def test_the_model_file_holds_it_bit_for_bit(tmp_path: Path) -> None:
    m, model = (
        moved(),
        with_term(plane(times="duty", shape=("odd",)), line("velocity_lagged", 0.3, 0.02)),
    )
    save_model(model, tmp_path / "model.yaml")
    again = load_model(tmp_path / "model.yaml")
    assert again.terms == model.terms
    assert again.digest() == model.digest()
    np.testing.assert_array_equal(predict(again, m), predict(model, m))
    assert again.digest() != guo().digest()
    text = (tmp_path / "model.yaml").read_text()
    assert "measured_velocity_deflection_duty" in text
    assert "measured, not explained" in text
    assert "[-0.06, 0.07]" in text  # the range that was learnt


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("quantities", ["colour"], "colour"),
        ("quantities", ["velocity", "deflection", "duty"], "one or two"),
        ("coefficients", [[1.0]], "42 numbers"),
        ("coefficients", [["exec('1')"] * 6] * 7, "finite numbers"),
        ("range", {"velocity": [0.0, 1.0]}, "that of the knots"),
        ("times", "colour", "colour"),
        ("lag", -1.0, "above 0 s"),
        ("code", "import os", "code"),
        ("knots", {"velocity": [0.0] * 11, "deflection": list(X_KNOTS)}, "that rise"),
    ],
)
def test_what_is_wrong_with_it_is_one_line(
    key: str, value: object, said: str, tmp_path: Path
) -> None:
    path = tmp_path / "model.yaml"
    term = (
        plane(quantities=("velocity_lagged", "deflection"), lag=0.1) if key == "lag" else plane()
    )
    save_model(with_term(term), path)
    document = yaml.safe_load(path.read_text())
    document["measured_terms"][term.name][key] = value
    path.write_text(yaml.safe_dump(document))
    with pytest.raises(InputError, match=f"measured_terms.*{said}") as error:
        load_model(path)
    assert "\n" not in str(error.value)


def test_a_form_without_room_for_it_says_so() -> None:
    with pytest.raises(InputError, match="measured_velocity_deflection"):
        static_damper(with_term(plane()))
