"""The forms of chapter 2 against the printed matrices and against one another."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest
from er_models.errors import InputError
from er_models.forms.descriptor import descriptor_form
from er_models.forms.linearise import NotThisForm
from er_models.forms.lipschitz import fingerprint, linearise
from er_models.forms.loss import Factors, damaged, lost_force
from er_models.forms.lti import lti_form
from er_models.forms.nlpv import DUTY, NLPVForm, nlpv_form
from er_models.forms.qlpv import qlpv_form
from er_models.forms.relative import relative_form
from er_models.model import Array, Model
from models_help import car as quarter_car
from models_help import exact_rates, random_points

m_s, m_us, k_s, k_t = 2.27, 0.25, 1396.0, 12270.0
k_0, c_0, k_1, c_1, f_c, tau = 263.1168, 64.6433, 204.0283, 492.6448, 29.2780, 0.0365
TABLE_2_1 = {
    ("quarter_car", "m_s"): (m_s, "kg"),
    ("quarter_car", "m_us"): (m_us, "kg"),
    ("quarter_car", "k_s"): (k_s, "N/m"),
    ("quarter_car", "k_t"): (k_t, "N/m"),
    ("passive", "k0"): (k_0, "N/m"),
    ("passive", "c0"): (c_0, "N s/m"),
    ("guo_yield", "k1"): (k_1, "1/m"),  # printed as N/m: the argument of tanh has no unit
    ("guo_yield", "c1"): (c_1, "s/m"),  # printed as N.s/m
    ("guo_yield", "f_c"): (f_c, "N/duty"),
    ("response", "tau"): (tau, "s"),
}


@pytest.fixture(scope="module")
def car() -> Model:
    """The quarter car of Table 2.1."""
    return quarter_car()


def damaged_states(model: Model, n: int) -> list[tuple[Array, float, float]]:
    """Random states (6,) with a lost force, duties and road rates."""
    points, random = random_points(model, n, seed=5), np.random.default_rng(6)
    return [(np.append(x, random.uniform(-30.0, 30.0)), u, rate) for x, u, rate in points]


def faulty(x: Array, u: float, road_rate: float) -> Array:
    """The equations (2.18), by hand: rates of the first five states (5,)."""
    z_def, v_s, z_t, v_us, f_er, f = x
    force = (k_s + k_0) * z_def + c_0 * (v_s - v_us) + f_er - f
    gate = f_c * u * np.tanh(k_1 * z_def + c_1 * (v_s - v_us))
    return np.array(
        [
            v_s - v_us,
            -force / m_s,
            v_us - road_rate,
            (force - k_t * z_t) / m_us,
            (gate - f_er) / tau,
        ]
    )


def test_parameters_are_those_of_table_2_1(car: Model) -> None:
    """Every value and unit of the table, and nothing else in the model."""
    for (effect, parameter), (value, unit) in TABLE_2_1.items():
        assert car.value(effect, parameter) == value
        assert car.catalogue[effect].parameter(parameter).unit == unit
    assert {(e, p) for e, values in car.effects.items() for p in values} == set(TABLE_2_1)


def test_gains_keep_their_form(car: Model) -> None:
    """Gain files carry these: the forms may not move by a digit."""
    assert fingerprint(car) == "e52c88030249b7ac"
    form = relative_form(car)
    parts = (form.A, form.B, form.D1, form.C, form.Gamma, form.F, form.chart)
    text = " ".join(f"{v:.12g}" for part in parts for v in np.ravel(part) + 0.0)
    assert hashlib.sha256(text.encode()).hexdigest()[:16] == "a738d2f698980d1f"


def test_lti_form_is_the_printed_one(car: Model) -> None:
    """A_s, B_s and D_sw below (2.8)."""
    k = k_s + k_0
    form = lti_form(car)
    body = np.array([-k, -c_0, k, c_0]) / m_s
    wheel = np.array([k, c_0, -(k + k_t), -c_0]) / m_us
    np.testing.assert_allclose(form.A, [[0, 1, 0, 0], body, [0, 0, 0, 1], wheel], rtol=1e-11)
    np.testing.assert_allclose(form.B, [0, -1 / m_s, 0, 1 / m_us], rtol=1e-11)
    np.testing.assert_allclose(form.D, [0, 0, 0, k_t / m_us], rtol=1e-11)
    np.testing.assert_allclose(form.C, [body, wheel, [1, 0, -1, 0]], rtol=1e-11)
    np.testing.assert_allclose(form.C_u, [-1 / m_s, 1 / m_us, 0], rtol=1e-11)
    np.testing.assert_allclose(form.C_r, [0, k_t / m_us, 0], rtol=1e-11)
    np.testing.assert_allclose(form.F, [k_0, c_0, -k_0, -c_0], rtol=1e-11)


def test_qlpv_form_is_the_printed_one(car: Model) -> None:
    """A_lc, B_lc and rho_lc of (2.10)."""
    form = qlpv_form(car)
    np.testing.assert_allclose([form.A, form.B], [-1 / tau, f_c / tau], rtol=1e-11)
    motion = np.array([0.003, -0.002])
    assert form.gate(motion) == pytest.approx(np.tanh(k_1 * 0.003 - c_1 * 0.002), rel=1e-10)
    assert form.rate(4.0, 0.5, -0.3) == pytest.approx((-0.3 * f_c * 0.5 - 4.0) / tau, rel=1e-11)


def test_nlpv_form_is_the_lipschitz_form_with_the_duty_as_rho(car: Model) -> None:
    """(2.13) equals (2.11), in both choices of state; noise reaches the outputs only."""
    assert DUTY == (0.0, 1.0)
    np.testing.assert_allclose(nlpv_form(car).B(0.4), [0, 0, 0, 0, 0.4 * f_c / tau], rtol=1e-11)
    for linear in (linearise(car), relative_form(car)):
        form = NLPVForm(linear)
        for x, u, unknown in random_points(car, 30, seed=1):
            x, omega = x[: linear.n], np.array([unknown, 0.7, -2.0])
            wanted = linear.rate(x, u, unknown)
            np.testing.assert_allclose(form.rate(x, u, omega), wanted, rtol=1e-12, atol=1e-9)
            noise = form.output(x, omega) - linear.C @ x
            np.testing.assert_allclose(noise, [0.007, -0.02], atol=1e-9)


def test_two_noises_need_a_square_d2(car: Model) -> None:
    """The printed column D2 puts one noise on both sensors: their difference would have none."""
    printed, ours = np.array([[0.01], [0.01]]), NLPVForm(linearise(car)).D2_bar[:, 1:]
    difference = np.array([1.0, -1.0])
    assert not np.any(difference @ printed)
    np.testing.assert_array_equal(ours, 0.01 * np.eye(2))
    assert np.linalg.norm(difference @ ours) > 0.01


def test_subsystems_together_are_the_lipschitz_form(car: Model) -> None:
    """(2.8) and (2.10) in a loop, taken to the thesis's state, are (2.11)."""
    whole, suspension, fluid = linearise(car), lti_form(car), qlpv_form(car)
    T = np.array([[1, 0, -1, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], float)
    back = np.linalg.inv(T)
    A = np.zeros((5, 5))
    A[:4, :4], A[:4, 4], A[4, 4] = T @ suspension.A @ back, T @ suspension.B, fluid.A
    np.testing.assert_allclose(A, whole.A, rtol=1e-10, atol=1e-8)
    np.testing.assert_allclose(fluid.B, whole.B[4], rtol=1e-12)
    np.testing.assert_allclose(suspension.C[:2] @ back, whole.C[:, :4], rtol=1e-10, atol=1e-8)
    np.testing.assert_allclose(suspension.F @ back, whole.F[:4], rtol=1e-10, atol=1e-8)
    np.testing.assert_allclose(fluid.Gamma @ [[1, 0, 0, 0, 0], [0, 1, 0, -1, 0]], whole.Gamma)
    for x, u, height in random_points(car, 30, seed=2):
        state, force = x[:4], x[4]
        q = T @ state + np.array([0.0, 0.0, -height, 0.0])
        gate = fluid.gate(relative_form(car).chart[:2] @ np.append(q, 0.0))
        rate = np.append(T @ suspension.rate(state, force, height), fluid.rate(force, u, gate))
        scale = np.abs(whole.A) @ np.abs(np.append(q, force)) + 1.0
        found = whole.rate(np.append(q, force), u, 0.0)
        assert np.all(np.abs(rate - found) <= 1e-9 * scale)
        outputs = suspension.output(state, force, height)
        np.testing.assert_allclose(outputs[:2], rate[[1, 3]], rtol=1e-7, atol=1e-6)
        assert outputs[2] == q[0]


def test_descriptor_form_is_the_corrected_one(car: Model) -> None:
    """E, A_f, B and the outputs of (2.19) as (2.18) demands; without its last column it is healthy."""
    form, healthy = descriptor_form(car), linearise(car)
    np.testing.assert_array_equal(form.E, np.eye(5, 6))
    np.testing.assert_array_equal(form.A[:, :5], healthy.A)
    np.testing.assert_array_equal(form.C[:, :5], healthy.C)
    np.testing.assert_allclose(form.A[:, 5], [0, 1 / m_s, 0, -1 / m_us, 0], rtol=1e-11)
    np.testing.assert_allclose(form.A[3, 4:], [1 / m_us, -1 / m_us], rtol=1e-11)
    np.testing.assert_allclose(form.A[4], [0, 0, 0, 0, -1 / tau, 0], rtol=1e-11)
    np.testing.assert_allclose(form.B, [0, 0, 0, 0, f_c / tau], rtol=1e-11)
    np.testing.assert_allclose(form.F, [k_0, c_0, 0, -c_0, 1, -1], rtol=1e-11)
    for x, u, road_rate in damaged_states(car, 50):
        wanted = faulty(x, u, road_rate)
        np.testing.assert_allclose(form.side(x, u, road_rate), wanted, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(form.C @ x, wanted[[1, 3]], rtol=1e-9, atol=1e-9)


def test_printed_2_19_disagrees_with_its_own_2_18(car: Model) -> None:
    """The printed rows of the wheel and of the fluid are off by far more than rounding; ours are not."""
    printed = descriptor_form(car).A.copy()
    printed[3, 5] = -1 / tau
    printed[4, 4:] = 0.0, -1 / tau
    wrong = []
    for x, u, road_rate in damaged_states(car, 50):
        gate = f_c / tau * u * np.tanh(k_1 * x[0] + c_1 * (x[1] - x[3]))
        found = printed @ x + np.array([0, 0, -road_rate, 0, gate])
        wrong.append(np.abs(found - faulty(x, u, road_rate)))
    wrong = np.max(wrong, axis=0)
    assert wrong[[0, 1, 2]].max() < 1e-8
    assert wrong[3] > 100.0
    assert wrong[4] > 500.0


FAULTS = [(1.0, 0.6, 1.0), (0.3, 1.0, 1.0), (1.0, 1.0, 0.7), (0.4, 0.8, 0.5)]


def left_force(x: Array, factors: tuple[float, float, float]) -> float:
    """Force of the faulty damper, (6.8) by hand [N]."""
    f_1, f_2, f_3 = factors
    return f_2 * (k_0 * x[0] + f_3 * (c_0 * (x[1] - x[3]) + f_1 * x[4]))


@pytest.mark.parametrize("factors", FAULTS)
def test_faults_are_weaker_parameters(car: Model, factors: tuple[float, float, float]) -> None:
    """The compiled car with smaller k0, c0 and f_c has the force (6.8), its F_er weaker alike."""
    weak = damaged(car, Factors(*factors))
    scale = np.array([1.0, 1.0, 1.0, 1.0, np.prod(factors)])
    for x, u, road_rate in random_points(car, 30, seed=8):
        rate, outputs = exact_rates(weak, scale * x, u, road_rate)
        healthy, _ = exact_rates(car, x, u, road_rate)
        assert outputs[2] == pytest.approx(left_force(x, factors), rel=1e-9)
        assert rate[4] == pytest.approx(scale[4] * healthy[4], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("factors", FAULTS)
def test_descriptor_with_a_lost_force_is_the_faulty_car(
    car: Model, factors: tuple[float, float, float]
) -> None:
    """The compiled car with the faults (6.8) moves as (2.19) with the f of these faults."""
    form, healthy, relative = descriptor_form(car), linearise(car), relative_form(car)
    weak = damaged(car, Factors(*factors))
    scale = np.array([1.0, 1.0, 1.0, 1.0, np.prod(factors)])
    for x, u, road_rate in random_points(car, 30, seed=8):
        rate, outputs = exact_rates(weak, scale * x, u, road_rate)
        f = lost_force(healthy, x, Factors(*factors))
        x_e = np.append(x, f)
        found = scale * form.side(x_e, u, road_rate)
        np.testing.assert_allclose(found, rate, rtol=1e-9, atol=1e-8)
        np.testing.assert_allclose(form.C @ x_e, outputs[:2], rtol=1e-9, atol=1e-8)
        assert form.F @ x_e == pytest.approx(outputs[2], rel=1e-9)
        again = lost_force(relative, relative.chart @ x, Factors(*factors))
        assert again == pytest.approx(f, rel=1e-9)


def test_a_leak_loses_a_share_of_the_force(car: Model) -> None:
    """(2.16): f = alpha F_d; healthy factors lose nothing, others than 0 to 1 are refused."""
    form = linearise(car)
    for x, _, _ in random_points(car, 10, seed=9):
        assert lost_force(form, x, Factors(leakage=0.6)) == pytest.approx(
            0.4 * (form.F @ x), rel=1e-12
        )
        assert lost_force(form, x, Factors()) == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(InputError, match=r"leakage: expected a factor.*1\.2"):
        Factors(leakage=1.2)


def test_frozen_gate_is_the_slope_of_the_form(car: Model) -> None:
    """Slope 1 is what a small motion feels at that duty, slope 0 what remains beyond yield."""
    for form in (linearise(car), relative_form(car)):
        small = 1e-7 * np.array([1.0, 0.3, -0.5, 0.8, 1.0])[: form.n]
        wanted = form.rate(small, 0.3, 0.0)
        np.testing.assert_allclose(form.frozen(0.3, 1.0) @ small, wanted, rtol=1e-6)
        np.testing.assert_array_equal(form.frozen(0.3, 0.0), form.A)
        assert np.linalg.norm(form.frozen(0.3, 0.5) - form.A) > 1.0


def test_every_form_refuses_a_damper_it_cannot_hold(car: Model) -> None:
    """A friction bends each of the forms, and each says which effect it is."""
    bent = car.with_effect("coulomb_friction")
    for make in (linearise, relative_form, lti_form, qlpv_form, nlpv_form, descriptor_form):
        with pytest.raises(NotThisForm, match="leave out one of coulomb_friction"):
            make(bent)
