"""The compiled step against SciPy: phi functions, the mean of the gate, whole samples."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from er_models.model import Array, Model
from er_observers.gains import Gains
from er_observers.observers.gate import gate_of, mean_gate, slopes_of, solve_gate
from er_observers.observers.kernel import SUBSTEP, advance, substeps
from er_observers.observers.phi import phi_functions
from er_observers.observers.table import NEARLY, substep_matrix, table_of
from er_observers.programs import OBSERVERS
from er_observers.running.ready import ready
from er_observers.synthesis.discrete import looked_up
from scipy.integrate import quad, solve_ivp
from scipy.linalg import expm


@pytest.mark.parametrize("size", [1e-6, 0.3, 3.0, 40.0])
def test_phi_functions(size: float) -> None:
    """Against exponentials of augmented matrices, small and large."""
    m = np.random.default_rng(4).normal(size=(4, 4)) * size - size * np.eye(4)
    augmented = np.zeros((12, 12))
    augmented[:4, :4] = m
    augmented[:4, 4:8] = augmented[4:8, 8:] = np.eye(4)
    whole = expm(augmented)
    phi = phi_functions(m)
    for k in range(3):
        exact = whole[:4, 4 * k : 4 * k + 4]
        np.testing.assert_allclose(phi[k], exact, rtol=1e-9, atol=1e-12 * np.abs(exact).max())


@pytest.mark.parametrize(
    ("s_0", "s_1"), [(0.0, 0.0), (-3.0, 5.0), (0.3, 0.305), (0.3, 0.3101), (40.0, -60.0), (700, 0)]
)
def test_mean_of_the_gate(s_0: float, s_1: float) -> None:
    """Against quadrature, across both formulas, and its derivative against differences."""
    mean, slope = mean_gate(float(s_0), float(s_1))
    exact = quad(lambda x: np.tanh(s_0 + x * (s_1 - s_0)), 0.0, 1.0, limit=400)[0]
    assert mean == pytest.approx(exact, abs=1e-9)
    h = 1e-5
    difference = (mean_gate(s_0, s_1 + h)[0] - mean_gate(s_0, s_1 - h)[0]) / (2.0 * h)
    assert slope == pytest.approx(difference, abs=1e-6)
    ends = slopes_of(s_0, gate_of(s_0)[0], s_1, gate_of(s_1)[0], mean)
    assert ends == pytest.approx((mean_gate(s_1, s_0)[1], slope), abs=1e-9)


def test_scalar_equation_has_its_root() -> None:
    """For every gain below two, the steepest included, and far starts."""
    random = np.random.default_rng(5)
    for _ in range(2000):
        s_0, free = random.normal(size=2) * 10.0 ** random.uniform(-2, 3, 2)
        gain = -(10.0 ** random.uniform(-3, 3)) if random.random() < 0.8 else random.uniform(0, 1)
        s_1, t_1, area_1, mean = solve_gate(s_0, *gate_of(s_0), free, gain)
        assert (t_1, area_1) == pytest.approx(gate_of(s_1), abs=1e-9)
        assert mean == pytest.approx(mean_gate(s_0, s_1)[0], abs=1e-9)
        assert abs(s_1 - free - gain * mean) <= 1e-8 * (1.0 + abs(free))


def continuous(gains: Gains, x: Array, y: Array, rho: float, dt: float) -> Array:
    """The observer's differential equation over one sample, with linear y."""
    form, gain = gains.form, gains.claim.solution.gain(rho)

    def rate(t: float, state: Array) -> Array:
        now = y[0] + t / dt * (y[1] - y[0])
        gate = form.B * rho * np.tanh(form.Gamma @ state)
        return np.asarray(form.A @ state + gate + gain @ (now - form.C @ state))

    found = solve_ivp(rate, (0.0, dt), x, method="Radau", rtol=1e-11, atol=1e-14)
    return np.asarray(found.y[:, -1])


@pytest.mark.parametrize("rho", [0.0, 0.3, 1.0])
def test_one_sample_is_the_differential_equation(gains: Gains, rho: float) -> None:
    """A passage through the gate within one sample; the error falls with the step."""
    x = np.array([1e-3, 0.03, 2e-4, 20.0 * rho])
    y = np.array([[2.0, 40.0], [-4.0, 90.0]])
    exact = continuous(gains, x, y, rho, 0.005)
    if rho > 0.0:
        assert np.sign(gains.form.Gamma @ x) != np.sign(gains.form.Gamma @ exact)
    errors = []
    for n in (substeps(0.005), 4 * substeps(0.005), 16 * substeps(0.005)):
        out = np.empty(4)
        end = advance(*gains.plan, x, y[0], y[1], np.zeros(2), rho, 0.005, n, out, 0.0)
        assert end == pytest.approx(gains.form.Gamma @ out, rel=1e-9, abs=1e-9)
        errors.append(np.abs((out - exact) / gains.plan.part("size")).max())
        force = abs(gains.form.F @ (out - exact))
        assert force < 0.02
    if rho > 0.0:
        assert errors[2] < 0.05 * errors[0]
    else:
        assert errors[0] < 1e-8


@pytest.mark.parametrize("name", OBSERVERS)
def test_the_table_is_as_near_to_the_law_as_it_says(
    car: Model, gain_file: Path, name: str
) -> None:
    """What is looked up at random duties, against the law's own substep and one sample made anew."""
    gains = ready(gain_file.parent / f"{name}.yaml", car, name)
    claim, random = gains.claim, np.random.default_rng(7)
    law, z, table = claim.solution.law, claim.sizes, looked_up(claim)
    weights = np.concatenate([np.ones(law.order), claim.scaling.output, claim.scaling.output, [1]])
    for rho in random.uniform(size=50):
        own = substep_matrix(law, law.T @ gains.form.B, z, rho, SUBSTEP)
        assert np.abs(weights * (table.at(rho) - own)).max() <= 1.01 * NEARLY
        state, y = (
            z * random.normal(size=z.size),
            random.normal(size=(3, 2)) * claim.scaling.output,
        )
        looked, fresh = np.empty_like(z), np.empty_like(z)
        advance(*gains.plan, state, *y, rho, 0.005, 4, looked, 0.0)
        advance(
            *gains.plan, state, *y, rho, 0.005 * (1.0 + 1e-8), 4, fresh, 0.0
        )  # no usual length
        assert np.abs((looked - fresh) / z).max() < 20.0 * NEARLY


def test_a_coarse_table_is_told(gains: Gains, monkeypatch: pytest.MonkeyPatch) -> None:
    """A table of the law's two duties alone would be off by a hundred times as much, and says so."""
    monkeypatch.setattr("er_observers.observers.table._HALVINGS", 0)
    claim = gains.claim
    rough = table_of(claim.solution.law, gains.form.B, claim.sizes, claim.scaling.output)
    assert len(rough.duties) == 2
    assert rough.gap > 100.0 * NEARLY


def test_a_bend_is_a_parabola(gains: Gains) -> None:
    """Outputs that follow a parabola, against an ODE solver; a straight line would be far off."""
    law, dt = gains.claim.solution.law, 0.005  # at duty 0, where nothing else is bent
    z = np.array([2e-4, 0.05, 1e-4, 2.0])
    y_0, y_1, bend = np.array([1.0, -4.0]), np.array([1.5, 6.0]), np.array([0.4, -5.0])

    def rate(t: float, z: Array) -> Array:
        th = t / dt
        y = y_0 + (y_1 - y_0) * th + bend * (th * th - th)
        return np.asarray(law.M[0] @ z + law.J[0] @ y)

    exact = solve_ivp(rate, (0.0, dt), z, method="Radau", rtol=1e-9, atol=1e-12).y[:, -1]
    errors = []
    for one in (bend, np.zeros(2)):
        out = np.empty(4)
        advance(*gains.plan, z, y_0, y_1, one, 0.0, dt, 4, out, 0.0)
        errors.append(np.abs((out - exact) / gains.plan.part("size"))[:3].max())
    assert errors[0] < 0.08 * errors[1]


def test_bridge_is_the_model_with_a_fading_tyre(gains: Gains) -> None:
    """Without measurement the state follows the model; the tyre deflection decays with 20 ms."""
    x, nothing, out = np.array([1e-3, 0.01, 3e-4, 1.0]), np.zeros(2), np.empty(4)
    advance(*gains.bridge, x, nothing, nothing, nothing, 0.0, 0.02, substeps(0.02), out, 0.0)
    assert out[2] == pytest.approx(3e-4 * np.exp(-1.0), rel=1e-9)
    assert out[3] == pytest.approx(np.exp(0.02 * gains.form.A[3, 3]), rel=1e-9)
