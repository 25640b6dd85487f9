"""Zeros, frequency responses and limits of the forms, against known systems and the thesis."""

from __future__ import annotations

import numpy as np
import pytest
from er_models.forms.descriptor import descriptor_form
from er_models.forms.lipschitz import LinearForm, linearise
from er_models.forms.lti import lti_form
from er_models.forms.passive import passive_peaks, passive_response
from er_models.forms.relative import relative_form
from er_models.forms.response import frequency_response, peaks
from er_models.forms.zeros import invariant_zeros
from er_models.model import Array, Model
from models_help import car as quarter_car
from scipy.linalg import eigvals, solve_continuous_are
from scipy.signal import tf2ss

HERTZ = np.geomspace(0.2, 60.0, 800)


@pytest.fixture(scope="module")
def car() -> Model:
    """The quarter car of Table 2.1."""
    return quarter_car()


def column(values: Array) -> Array:
    """A vector as a matrix of one column."""
    return values[:, None]


def test_zeros_of_a_known_transfer_function() -> None:
    """(s + 2)(s^2 + 2 s + 50) over (s + 1)(s + 3)(s + 5)(s + 7), scaled badly on purpose."""
    A, B, C, D = tf2ss(np.polymul([1, 2], [1, 2, 50]), np.poly([-1, -3, -5, -7]))
    size = np.diag([1e-3, 1.0, 50.0, 1e4])
    A, B, C = size @ A @ np.linalg.inv(size), size @ B, C @ np.linalg.inv(size)
    np.testing.assert_allclose(invariant_zeros(A, B, C, D), [-2, -1 - 7j, -1 + 7j], rtol=1e-6)
    assert invariant_zeros(np.diag([-1.0, -2.0]), np.ones((2, 1)), np.eye(2)).size == 0


def test_zeros_of_square_systems_are_those_of_the_pencil() -> None:
    """Random systems with feedthrough: the generalised eigenvalues of the system matrix."""
    random = np.random.default_rng(2)
    for _ in range(10):
        A, D, C, H = (random.normal(size=s) for s in ((5, 5), (5, 2), (2, 5), (2, 2)))
        pencil, mass = np.block([[A, D], [C, H]]), np.zeros((7, 7))
        mass[:5, :5] = np.eye(5)
        found = eigvals(pencil, mass)
        wanted = np.poly(found[np.abs(found) < 1e6])
        np.testing.assert_allclose(np.poly(invariant_zeros(A, D, C, H)), wanted, rtol=1e-6)


def test_zeros_refuse_inputs_that_nothing_shows() -> None:
    """Two inputs that act alike, or one that no output ever sees, leave every s a zero."""
    A, C = np.diag([-1.0, -2.0, -3.0]), np.array([[1.0, 1.0, 0.0]])
    with pytest.raises(ValueError, match="two inputs act alike"):
        invariant_zeros(A, np.array([[1.0, 2.0], [0.0, 0.0], [0.0, 0.0]]), C)
    with pytest.raises(ValueError, match="no output shows"):
        invariant_zeros(A, np.array([[0.0], [0.0], [1.0]]), C)


def test_only_absolute_velocities_make_a_zero_at_the_origin(car: Model) -> None:
    """A climb at constant speed is the one motion accelerometers miss; rank(C D1) = rank(D1) = 1 in both."""
    thesis, relative = linearise(car), relative_form(car)
    np.testing.assert_allclose(
        invariant_zeros(thesis.A, column(thesis.D1), thesis.C), [0.0], atol=1e-6
    )
    assert invariant_zeros(relative.A, column(relative.D1), relative.C).size == 0
    for form in (thesis, relative):
        assert np.linalg.matrix_rank(column(form.D1)) == 1
        assert np.linalg.matrix_rank(form.C @ column(form.D1)) == 1


def fault_zeros(form: LinearForm, lost: Array, C: Array, H: Array) -> Array:
    """Zeros from unknown input and lost force to outputs."""
    D = np.column_stack([form.D1, lost])
    return invariant_zeros(form.A, D, C, np.column_stack([np.zeros_like(H), H]))


def test_an_unknown_fault_needs_a_sensor_of_the_deflection(car: Model) -> None:
    """(2.19) with accelerometers alone cannot tell a lost force from a deflection; with a deflection it can.

    Any deflection a + b t with a lost force that holds it shows in no accelerometer: a double zero at
    s = 0. With the deflection measured only the decay of F_er itself is left, at -1/tau.
    """
    relative, lost = relative_form(car), descriptor_form(car)
    column_f = relative.chart @ lost.A[:, 5]
    both = fault_zeros(relative, column_f, relative.C, lost.C[:, 5:])
    decay = -1.0 / car.value("response", "tau")
    np.testing.assert_allclose(both, [decay, 0.0, 0.0], atol=1e-3)
    C = np.vstack([relative.C, [1.0, 0.0, 0.0, 0.0]])
    H = np.vstack([lost.C[:, 5:], [[0.0]]])
    np.testing.assert_allclose(fault_zeros(relative, column_f, C, H), [decay], rtol=1e-6)


def test_descriptor_state_follows_from_the_outputs_but_not_its_constant_part(car: Model) -> None:
    """rank [E; C] = 6: the lost force is no longer free once y is known; at s = 0 a pencil loses rank."""
    form = descriptor_form(car)
    assert np.linalg.matrix_rank(form.E) == 5
    assert np.linalg.matrix_rank(np.vstack([form.E, form.C])) == 6
    hidden = np.zeros(6)
    hidden[0] = 1e-3
    hidden[5] = 1e-3 * (car.value("quarter_car", "k_s") + car.value("passive", "k0"))
    np.testing.assert_allclose(form.A @ hidden, 0.0, atol=1e-9)
    np.testing.assert_allclose(form.C @ hidden, 0.0, atol=1e-9)


@pytest.mark.parametrize("make", [linearise, relative_form])
def test_gate_error_reaches_the_gate_alike_for_every_stabilising_gain(
    car: Model, make: type
) -> None:
    """At s = 0, from an error of the gate to Gamma e: -k1 f_c U / (k_s + k0) = -3.6004 U whatever L is."""
    form: LinearForm = make(car)
    k = car.value("quarter_car", "k_s") + car.value("passive", "k0")
    bound = k / (car.value("guo_yield", "k1") * car.value("guo_yield", "f_c"))
    assert bound == pytest.approx(0.2777, abs=5e-5)
    assert -1.0 / bound == pytest.approx(-3.6004, abs=5e-5)
    random = np.random.default_rng(7)
    gains = []
    for _ in range(20):
        weights = np.diag(10.0 ** random.uniform(-2.0, 4.0, form.n))
        noise = np.diag(10.0 ** random.uniform(-2.0, 2.0, 2))
        L = (
            solve_continuous_are(form.A.T, form.C.T, weights, noise)
            @ form.C.T
            @ np.linalg.inv(noise)
        )
        gains.append(L)
        loop = form.A - L @ form.C
        assert np.linalg.eigvals(loop).real.max() < -0.01
        for duty in (0.1, 0.2777, 1.0):
            static = float(form.Gamma @ np.linalg.solve(-loop, form.B * duty))
            assert static == pytest.approx(-duty / bound, rel=1e-6)
            assert (abs(static) > 1.0) == (duty > 0.2777)
    assert np.std([np.linalg.norm(L) for L in gains]) > 1.0  # gains that differ indeed


def test_response_of_a_known_system() -> None:
    """A first-order lag with feedthrough, and a resonance whose peak is known."""
    found = frequency_response(
        np.array([[-4.0]]), np.array([[4.0]]), np.eye(1), HERTZ, np.array([[0.5]])
    )
    np.testing.assert_allclose(found[:, 0, 0], 4.0 / (2j * np.pi * HERTZ + 4.0) + 0.5, rtol=1e-12)
    omega, zeta = 2.0 * np.pi * 5.0, 0.1
    A = np.array([[0.0, 1.0], [-(omega**2), -2.0 * zeta * omega]])
    gain = np.abs(frequency_response(A, np.array([[0.0], [omega**2]]), np.eye(2)[:1], HERTZ))
    (peak,) = peaks(HERTZ, gain[:, 0, 0])
    assert peak.hertz == pytest.approx(5.0 * np.sqrt(1.0 - 2.0 * zeta**2), rel=1e-4)
    assert peak.gain == pytest.approx(1.0 / (2.0 * zeta * np.sqrt(1.0 - zeta**2)), rel=1e-4)


def test_passive_car_peaks_near_4_and_20_hz(car: Model) -> None:
    """Figures 6.13 to 6.15: body and wheel near 4 Hz, the wheel again near 20 Hz; one peak of the deflection."""
    found = passive_peaks(car, HERTZ)
    assert [p.hertz for p in found["z_s"]] == pytest.approx([3.83], abs=0.01)
    assert [p.hertz for p in found["z_us"]] == pytest.approx([4.30, 18.43], abs=0.01)
    assert [p.hertz for p in found["z_def"]] == pytest.approx([5.64], abs=0.01)
    response = np.abs(passive_response(car, np.array([1e-3])))[0]
    np.testing.assert_allclose(response, [1.0, 1.0, 0.0], atol=1e-6)


def test_passive_car_in_the_weights_of_chapter_6(car: Model) -> None:
    """With W_zr, W_zs, W_zus of 6.3.1 the passive car has a gain of 0.1889 at 3.34 Hz; 0.07 sqrt(5) at rest."""
    hertz = np.linspace(1e-3, 40.0, 20001)
    response = passive_response(car, hertz)
    comfort, hold = 2.0 * 4.0 / (1j * hertz + 4.0), 20.0 / (1j * hertz + 20.0)
    gain = 0.07 * np.hypot(np.abs(comfort * response[:, 0]), np.abs(hold * response[:, 1]))
    (peak,) = peaks(hertz, gain)
    assert peak.hertz == pytest.approx(3.34, abs=0.01)
    assert peak.gain == pytest.approx(0.1889, abs=5e-5)
    assert gain[0] == pytest.approx(0.07 * np.sqrt(5.0), rel=1e-4)


def test_absolute_and_relative_forms_answer_the_road_alike(car: Model) -> None:
    """Road rate to force and deflection at frozen gates: the relative form, fed the tyre's rate, gives the same."""
    thesis, relative = linearise(car), relative_form(car)
    rows = np.vstack([thesis.F, np.eye(5)[0]])
    tyre = np.eye(5)[2:3]
    for duty, slope in ((0.0, 0.0), (0.3, 1.0), (1.0, 0.2)):
        A, D = thesis.frozen(duty, slope), column(thesis.D1)
        whole = frequency_response(A, D, np.vstack([rows, tyre]), HERTZ)[:, :, 0]
        part = frequency_response(
            relative.frozen(duty, slope),
            column(relative.D1),
            np.vstack([relative.F, np.eye(4)[0]]),
            HERTZ,
        )[:, :, 0]
        tyre_rate = 2j * np.pi * HERTZ * whole[:, 2]
        np.testing.assert_allclose(part * tyre_rate[:, None], whole[:, :2], rtol=1e-8)


def test_road_height_and_road_rate_make_one_response(car: Model) -> None:
    """(2.8) from z_r equals j omega times (2.11) from its rate, for all three outputs."""
    suspension, whole = lti_form(car), linearise(car)
    by_height = frequency_response(
        suspension.A, column(suspension.D), suspension.C, HERTZ, column(suspension.C_r)
    )
    rows = np.vstack([whole.C, np.eye(5)[0]])
    by_rate = frequency_response(whole.A, column(whole.D1), rows, HERTZ)
    s = 2j * np.pi * HERTZ[:, None, None]
    np.testing.assert_allclose(s * by_rate, by_height, rtol=1e-9)
