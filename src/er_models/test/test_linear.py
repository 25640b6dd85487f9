"""Linear forms against the printed thesis matrices, the right-hand side, and known facts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from er_models.catalogue import CATALOGUE
from er_models.effect import Effect, Param, Signature
from er_models.errors import ErError, InputError
from er_models.files import load_model
from er_models.linear import (
    LinearForm,
    NotThisForm,
    fingerprint,
    linearise,
    relative_form,
)
from er_models.model import Array, Model
from models_help import exact_rates, random_points

CAR = Path(__file__).resolve().parents[3] / "config" / "vehicles" / "inove_quarter_car.yaml"


@pytest.fixture(scope="module")
def car() -> Model:
    """The quarter car of Table 2.1."""
    return load_model(CAR)


def rosenbrock(form: LinearForm, s: complex) -> float:
    """Smallest singular value of the system pencil, rows and columns scaled to one."""
    n = form.n
    top = np.column_stack([s * np.eye(n) - form.A, -form.D1])
    pencil = np.vstack([top, np.column_stack([form.C, np.zeros(2)])])
    pencil = pencil / np.maximum(np.abs(pencil).max(axis=1, keepdims=True), 1e-300)
    pencil = pencil / np.abs(pencil).max(axis=0)
    return float(np.linalg.svd(pencil, compute_uv=False)[-1])


def test_thesis_form_is_the_printed_one(car: Model) -> None:
    """Matrices (2.11)-(2.14), (2.20) with Table 2.1."""
    m_s, m_us, k_s, k_t, k_0, c_0 = 2.27, 0.25, 1396.0, 12270.0, 263.1168, 64.6433
    k_1, c_1, f_c, tau = 204.0283, 492.6448, 29.2780, 0.0365
    k = k_s + k_0
    body = np.array([-k, -c_0, 0.0, c_0, -1.0]) / m_s
    wheel = np.array([k, c_0, -k_t, -c_0, 1.0]) / m_us
    A = np.array([[0, 1, 0, -1, 0], body, [0, 0, 0, 1, 0], wheel, [0, 0, 0, 0, -1 / tau]])
    form = linearise(car)
    np.testing.assert_allclose(form.A, A, rtol=1e-11)
    np.testing.assert_allclose(form.B, [0, 0, 0, 0, f_c / tau], rtol=1e-11)
    np.testing.assert_allclose(form.D1, [0, 0, -1, 0, 0], rtol=1e-12)
    np.testing.assert_allclose(form.C, [body, wheel], rtol=1e-11)
    np.testing.assert_allclose(form.Gamma, [k_1, c_1, 0, -c_1, 0], rtol=1e-11)
    np.testing.assert_allclose(form.F, [k_0, c_0, 0, -c_0, 1], rtol=1e-11)


def test_both_forms_are_the_right_hand_side(car: Model) -> None:
    """Rates, outputs and force agree with the equations at random states, duties and roads."""
    thesis, relative = linearise(car), relative_form(car)
    for x, u, road_rate in random_points(car, 50, seed=3):
        rate, outputs = exact_rates(car, x, u, road_rate)
        x_r, tyre_rate = relative.chart @ x, rate[2]
        for form, state, unknown, wanted in (
            (thesis, x, road_rate, rate),
            (relative, x_r, tyre_rate, relative.chart @ rate),
        ):
            gate = form.B * u * np.tanh(form.Gamma @ state)
            found = form.A @ state + gate + form.D1 * unknown
            np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(form.C @ state, outputs[:2], rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(form.F @ state, outputs[2], rtol=1e-9)


def test_passive_peaks_near_4_and_20_hz(car: Model) -> None:
    """Road to wheel has two resonances, near 4 and 20 Hz, and road to body one near 4 Hz."""
    form, hertz = linearise(car), np.linspace(0.5, 60.0, 4000)
    pencils = 2j * np.pi * hertz[:, None, None] * np.eye(5) - form.A
    gains = np.abs(np.linalg.solve(pencils, np.broadcast_to(form.D1[:, None], (4000, 5, 1))))

    def peaks(state: int) -> Array:
        g = gains[:, state, 0]
        return hertz[1:-1][(g[1:-1] > g[:-2]) & (g[1:-1] > g[2:])]

    assert peaks(3) == pytest.approx([4.3, 18.4], abs=0.3)
    assert peaks(1) == pytest.approx([3.8], abs=0.3)


def test_only_the_thesis_state_has_a_zero_at_the_origin(car: Model) -> None:
    """A car climbing at constant speed is invisible in absolute velocities, not in relative."""
    thesis, relative = linearise(car), relative_form(car)
    climbing = np.array([0.0, 1.0, 0.0, 1.0, 0.0])
    np.testing.assert_allclose(thesis.A @ climbing + thesis.D1, 0.0, atol=1e-9)
    np.testing.assert_allclose(thesis.C @ climbing, 0.0, atol=1e-9)
    assert rosenbrock(thesis, 0.0) < 1e-12
    assert rosenbrock(relative, 0.0) > 1e-3
    points = [complex(a, b) for a in (-300, -30, -3, 0, 3, 30) for b in (0, 1, 10, 100, 1000)]
    assert min(rosenbrock(relative, s) for s in points) > 1e-8
    for form in (thesis, relative):
        assert np.linalg.matrix_rank(form.C @ form.D1[:, None]) == 1


def test_hidden_error_of_the_gate_needs_duty_below_0_2777(car: Model) -> None:
    """Fact 1: a constant error d of the gate hides in the deflection, Gamma e = -3.6004 d."""
    form = relative_form(car)
    rows = np.vstack([form.A, form.C])
    hidden, *_ = np.linalg.lstsq(rows, np.append(-form.B, [0.0, 0.0]), rcond=None)
    np.testing.assert_allclose(rows @ hidden, np.append(-form.B, [0.0, 0.0]), atol=1e-6)
    gain = float(form.Gamma @ hidden)
    assert gain == pytest.approx(-3.6004, abs=1e-4)
    assert 1.0 / abs(gain) == pytest.approx(0.2777, abs=1e-4)
    k = car.value("quarter_car", "k_s") + car.value("passive", "k0")
    yields = car.value("guo_yield", "k1") * car.value("guo_yield", "f_c")
    assert -1.0 / gain == pytest.approx(k / yields, rel=1e-9)


@pytest.mark.parametrize("name", [e.name for e in CATALOGUE.candidates()])
def test_every_effect_is_held_exactly_or_refused(car: Model, name: str) -> None:
    """With any effect of the catalogue added, the form equals the equations or says it cannot."""
    model = car.with_effect(name)
    form = refusal = None
    try:
        form = linearise(model)
    except ErError as error:
        refusal = str(error)
    if form is None:
        assert refusal is not None
        assert name in refusal
        assert "\n" not in refusal
        return
    for x, u, road_rate in random_points(model, 20, seed=11):
        rate, outputs = exact_rates(model, x, u, road_rate)
        gate = form.B * u * np.tanh(form.Gamma @ x)
        scale = np.abs(form.A) @ np.abs(x) + np.abs(form.B) + np.abs(form.D1)
        assert np.all(np.abs(form.A @ x + gate + form.D1 * road_rate - rate) <= 1e-6 * scale)
        np.testing.assert_allclose(form.F @ x, outputs[2], rtol=1e-6, atol=1e-6)


def test_refuses_what_it_cannot_hold(car: Model) -> None:
    """Missing parts and bent equations are refused in words that say what to do."""
    with pytest.raises(InputError, match=r"effects\.quarter_car.*nothing"):
        linearise(car.without_effect("quarter_car"))
    with pytest.raises(InputError, match=r"effects\.response.*nothing"):
        linearise(car.without_effect("response"))
    with pytest.raises(NotThisForm, match=r"F_d departs.*leave out one of coulomb_friction"):
        linearise(car.with_effect("coulomb_friction"))
    bingham = car.without_effect("guo_yield").with_effect("bingham_yield")
    with pytest.raises(NotThisForm, match="departs"):
        linearise(bingham)


def spare_force(k: float, x: float) -> float:
    """Force of an effect that no model here uses [N]."""
    return k * x


@pytest.mark.slow
def test_a_longer_catalogue_keeps_the_fingerprint(car: Model) -> None:
    """Gains stay valid when somebody adds an effect that the model does not have."""
    spare = Effect(
        name="spare",
        stage="force",
        title="Unused",
        physics="In the catalogue but not in the model.",
        parameters=(Param("k", "N/m", 0.0, 1.0, 0.0, (0.1,), "stiffness"),),
        hooks={"force": spare_force},
        signature=Signature(mark="none", plane="time", experiment="none"),
        source="none",
    )
    longer = replace(car, catalogue=CATALOGUE.extended([spare]))
    assert longer.digest() != car.digest()
    assert fingerprint(longer) == fingerprint(car)


def test_fingerprint_follows_the_matrices(car: Model) -> None:
    """Name and source do not matter; any parameter of the form does."""
    own = fingerprint(car)
    assert fingerprint(replace(car, name="other", source="elsewhere")) == own
    for effect, parameter in (
        ("quarter_car", "m_s"),
        ("quarter_car", "k_t"),
        ("guo_yield", "c1"),
        ("guo_yield", "f_c"),
        ("response", "tau"),
        ("passive", "k0"),
    ):
        values = dict(car.effects[effect])
        values[parameter] *= 1.0 + 1e-9
        assert fingerprint(replace(car, effects={**car.effects, effect: values})) != own
