"""One sample of the LPV controller: what is given lies in the faulty domain, and the inverse damper model makes it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from er_ftc_controller.force_loop import ForceLoop, LoopState, duty_for
from er_ftc_controller.gains import Loaded, load_gains
from er_ftc_controller.lpv import Lpv, controller, start, step
from er_models.errors import InputError
from er_models.files import load_model
from er_models.forms.loss import Factors
from er_models.static_damper import static_damper

CONFIG = Path(__file__).resolve().parents[3] / "config"
LEAK = Factors(leakage=0.6)


@pytest.fixture(scope="module")
def loaded() -> Loaded:
    car = load_model(CONFIG / "vehicles" / "inove_quarter_car.yaml")
    return load_gains(CONFIG / "gains" / "lpv_ftc.yaml", car)


@pytest.fixture(scope="module")
def lpv(loaded: Loaded) -> Lpv:
    damper = static_damper(load_model(CONFIG / "dampers" / "inove_bingham.yaml"))
    return controller(loaded, damper, (0.0, 0.3), mu=0.1)


def test_the_duty_makes_the_nearest_force_of_the_faulty_damper(lpv: Lpv) -> None:
    state, t = start(lpv), 0.005 * np.arange(600)
    x, v = 0.006 * np.sin(25.0 * t), 0.15 * np.cos(25.0 * t)
    inverse = ForceLoop(lpv.damper, 0.03, lpv.duties, horizon=math.inf, least_gate=0.0)
    rhos, inside = [], 0
    for a, b in zip(x, v, strict=True):
        state, command = step(lpv, state, float(a), (float(a), float(b)), LEAK)
        gate = float(lpv.damper.gate(a, b))
        loop, duty = duty_for(
            inverse, LoopState(), command.given - command.passive, gate, 0.005, LEAK
        )
        assert loop.duty == duty
        force = lpv.damper.force(np.array(a), np.array(b), duty, LEAK)
        assert float(force) == pytest.approx(command.given, abs=1e-9)
        domain = lpv.damper.domain(np.array(a), np.array(b), lpv.duties, LEAK)
        assert domain.low - 1e-9 <= command.given <= domain.high + 1e-9
        inside += command.wanted == command.given
        rhos.append(command.rho)
    assert 0 < inside < t.size
    assert (min(rhos), max(rhos)) == (lpv.schedule.low, lpv.schedule.high)


@pytest.mark.parametrize(("rate", "slower"), [(1000.0, 200.0), (200.0, 100.0)])
def test_it_is_as_fast_at_every_rate(lpv: Lpv, loaded: Loaded, rate: float, slower: float) -> None:
    """What the slower one does in a sample, the faster one does in the same time."""
    fast, slow = (controller(loaded, lpv.damper, lpv.duties, 0.1, r) for r in (rate, slower))
    samples = round(rate / slower)
    for i in range(2):
        whole = sum(np.linalg.matrix_power(fast.A[i], k) for k in range(samples))
        assert np.allclose(np.linalg.matrix_power(fast.A[i], samples), slow.A[i])
        assert np.allclose(whole @ fast.B[i], slow.B[i])
        assert np.allclose(whole @ fast.E[i], slow.E[i])
    assert np.array_equal(fast.C, slow.C)


def test_a_rate_without_a_proof_is_refused(lpv: Lpv, loaded: Loaded) -> None:
    with pytest.raises(InputError, match=r"rate: expected samples per second .* found 20"):
        controller(loaded, lpv.damper, lpv.duties, 0.1, 20.0)


def test_a_constant_deflection_ends_at_the_vertex_own_gain(lpv: Lpv) -> None:
    """Held at the greatest rho the state settles where x = A x + B y, within the interpolation's exact end."""
    n, state = lpv.A.shape[1], start(lpv)
    for _ in range(3000):
        state, asked = step(
            lpv, state._replace(rho=lpv.schedule.high), 1e-5, (1e-5, -1.0), Factors()
        )
    assert asked.given == asked.wanted
    settled = np.linalg.solve(np.eye(n) - lpv.A[1], lpv.B[1] * 1e-5)
    assert np.allclose(state.x, settled, rtol=1e-3)


def test_a_force_that_is_not_given_does_not_wind_the_controller_up(lpv: Lpv) -> None:
    """At rest, where no force can be given, its state dies away as that of the observer in it, not as its own."""

    def radius(A: np.ndarray) -> float:
        return float(np.abs(np.linalg.eigvals(A)).max())

    told = lpv.A[0] - np.outer(lpv.E[0], lpv.C[0])
    assert radius(told) < radius(lpv.A[0])
    first = np.ones(lpv.A.shape[1])
    state = start(lpv)._replace(x=first)
    for _ in range(200):
        state, asked = step(lpv, state._replace(rho=lpv.schedule.low), 0.0, (0.0, 0.0), Factors())
        assert asked.given == 0.0
    assert np.allclose(state.x, np.linalg.matrix_power(told, 200) @ first, atol=1e-9)


def test_what_a_leak_took_of_the_passive_force_is_asked_for_again(lpv: Lpv) -> None:
    state, (x, v) = start(lpv), (0.002, 0.1)
    _, without = step(lpv, state, x, (x, v), LEAK)
    _, half = step(lpv, state, x, (x, v), LEAK, restore=0.5)
    lost = 0.4 * float(lpv.damper.passive(np.array(x), np.array(v)))
    assert half.wanted - without.wanted == pytest.approx(0.5 * lost)
    assert step(lpv, state, x, (x, v), Factors(electrical=0.5), 1.0)[1].wanted == pytest.approx(
        step(lpv, state, x, (x, v), Factors())[1].wanted
    )
