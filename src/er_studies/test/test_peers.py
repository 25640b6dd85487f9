"""The Kalman filters are what they say: against the textbook where the gate is closed, against samples where not."""

from __future__ import annotations

import numpy as np
import pytest
from er_models.linear import LinearForm, relative_form
from er_models.model import Model
from er_observers.filters.flow import flow, jacobian, noise_covariance, substep_matrices
from er_observers.filters.unscented import predict_unscented
from er_observers.observers.status import Status
from er_observers.running.runtime import Sample
from er_studies.observers import kalman
from scipy.integrate import solve_ivp

X = np.array([0.002, 0.01, 0.001, 3.0])


@pytest.fixture(scope="module")
def form(car: Model) -> LinearForm:
    return relative_form(car)


@pytest.mark.parametrize("name", sorted(kalman.KINDS))
def test_without_field_both_are_the_textbook_filter(car, form, name):
    """Predict and correct as in any textbook, all outputs at once, no square-root tricks."""
    p = kalman.make(name, car)
    random = np.random.default_rng(0)
    samples = [Sample(0.005 * k, *random.normal(size=2), 0.0) for k in range(40)]
    n_sub = p.kind.n_sub
    transition = np.linalg.matrix_power(p.linear, n_sub)
    powers = [np.linalg.matrix_power(p.linear, k) for k in range(n_sub)]
    noise = sum(a @ p.noise @ a.T for a in powers)
    x, P = X.copy(), p.first.copy()
    state = kalman.start(p, samples[0], X)
    for k, sample in enumerate(samples):
        if k:
            x, P = transition @ x, transition @ P @ transition.T + noise
            state, _ = kalman.step(p, state, sample)
        K = P @ form.C.T @ np.linalg.inv(form.C @ P @ form.C.T + np.diag(p.variance))
        x, P = x + K @ (np.array(sample[1:3]) - form.C @ x), P - K @ form.C @ P
        assert state.x == pytest.approx(x, rel=1e-7, abs=1e-9)
        assert pytest.approx(P, rel=1e-6, abs=1e-12) == state.P
        assert state.estimate.force == pytest.approx(form.F @ state.x)


def test_the_noise_of_a_substep_is_the_integral(form):
    density, h = np.array([0.0, 1e-6, 2e-5, 0.1]), 1e-3
    grid = np.linspace(0.0, h, 2001)
    grown = [substep_matrices(form, s)[0] for s in grid]
    integrand = np.array([a @ np.diag(density) @ a.T for a in grown])
    wanted = np.trapezoid(integrand, grid, axis=0)
    assert noise_covariance(form, density, h) == pytest.approx(wanted, rel=1e-5, abs=1e-15)


def test_a_substep_follows_the_model_and_its_jacobian_is_its_derivative(form):
    h, duty = 1.25e-3, 0.3
    linear, kick = substep_matrices(form, h)

    def moved(x):
        end = x.copy()
        return end, flow(linear, kick, form.Gamma, duty, end)

    exact = solve_ivp(lambda _, x: form.rate(x, duty, 0.0), (0, h), X, rtol=1e-10, atol=1e-13)
    assert moved(X)[0] == pytest.approx(exact.y[:, -1], rel=2e-3)
    J = np.empty((4, 4))
    jacobian(linear, kick, form.Gamma, duty, moved(X)[1], J)
    size = np.array([1e-3, 0.05, 1e-3, 5.0])
    for j in range(4):
        step = 1e-5 * size[j] * np.eye(4)[j]
        column = (moved(X + step)[0] - moved(X - step)[0]) / (2e-5 * size[j])
        assert J[:, j] / size == pytest.approx(column / size, rel=1e-4, abs=1e-4)


def test_the_unscented_prediction_has_the_mean_of_many_samples(form):
    """Where the gate bends, the mean moves; a linearised filter would not know."""
    linear, kick = substep_matrices(form, 1.25e-3)
    spread = np.array([1e-3, 4e-3, 1e-5, 0.1])
    x, P = np.zeros(4), np.diag(spread**2)
    x[1] = 3e-3
    many = x + spread * np.random.default_rng(1).standard_normal((20000, 4))
    centre = x.copy()
    flow(linear, kick, form.Gamma, 1.0, centre)
    predict_unscented(linear, kick, form.Gamma, np.zeros((4, 4)), 1.0, x, P)
    for one in many:
        flow(linear, kick, form.Gamma, 1.0, one)
    mean = many.mean(axis=0)
    assert abs(x[3] - mean[3]) < 0.2 * abs(centre[3] - mean[3])
    assert np.sqrt(np.diag(P)) == pytest.approx(many.std(axis=0), rel=0.1)


@pytest.mark.parametrize("name", sorted(kalman.KINDS))
def test_gaps_late_samples_and_nonsense(car, name):
    p = kalman.make(name, car)
    state = kalman.start(p, Sample(0.0, 0.1, -0.1, 0.2))
    late, _ = kalman.step(p, state, Sample(-0.005, 5.0, 5.0, 0.2))
    assert late is state
    missed, estimate = kalman.step(p, state, Sample(0.005, np.nan, 0.0, np.nan))
    assert missed.duty == 0.2
    assert estimate.status is Status.OK
    assert missed.P[2, 2] > state.P[2, 2]
    broken = state._replace(x=np.full(4, np.inf))
    assert kalman.step(p, broken, Sample(0.005, 0.0, 0.0, 0.2))[1].status is Status.INVALID
