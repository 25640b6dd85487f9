"""Facts 1 to 3 of the problem: what no observer gain can do, with the numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from er_models.linear import LinearForm, linearise, relative_form
from er_models.model import Model
from er_observers.scaling import Scaling
from er_observers.synthesis import make
from er_observers.synthesis.conditioning import RESOLVED, least_condition
from er_observers.synthesis.family import luenberger_family
from er_observers.synthesis.necessary import (
    decoupling_ranks,
    road_blind_gain,
    static_gate_gain,
    undetectable,
    violated,
)
from er_observers.synthesis.scaled import scale
from er_observers.synthesis.spec import (
    LIPSCHITZ,
    SLOPE,
    Output,
    Spec,
    SynthesisFailed,
    force_output,
    state_output,
)

PRINTED = np.array(
    [
        [
            [-3.4572, -0.0015],
            [-3.7771, -0.0022],
            [-5.1680, -4.8398],
            [-0.4777, 0.9998],
            [107.9617, -0.9147],
        ],
        [
            [-3.4397, -0.0015],
            [-3.7503, -0.0022],
            [-5.1910, -4.8392],
            [-0.4750, 0.9998],
            [42.2868, 0.0204],
        ],
    ]
)
"""Vertex gains printed in section 4.4.1 of the thesis."""


def test_gate_error_hides_at_zero_frequency_whatever_the_gain(car: Model) -> None:
    """From d to Gamma e the static gain is -3.6004 for random stabilising gains alike."""
    form, random = relative_form(car), np.random.default_rng(1)
    expected = static_gate_gain(form, 1.0)
    assert expected == pytest.approx(-3.6004, abs=1e-4)
    stable = 0
    for _ in range(200):
        gain = random.normal(size=(4, 2)) * np.array([[0.1], [50.0], [1.0], [3000.0]])
        loop = form.A - gain @ form.C
        if np.linalg.eigvals(loop).real.max() < -1e-3:
            stable += 1
            found = float(form.Gamma @ np.linalg.solve(loop, -form.B))
            assert found == pytest.approx(expected, rel=1e-6)
    assert stable >= 5


def test_thesis_gains_break_the_lipschitz_small_gain(car: Model) -> None:
    """The printed polytopic gains: peak gain from d to Gamma e of 13.2 where below 1 is needed."""
    form, omega = linearise(car), np.logspace(-2, 6, 4000)
    pencils = 1j * omega[:, None, None] * np.eye(5) - (form.A - PRINTED[1] @ form.C)
    entry = np.broadcast_to(form.B[:, None].astype(complex), (omega.size, 5, 1))
    gains = np.abs(form.Gamma @ np.linalg.solve(pencils, entry)[:, :, 0].T)
    assert gains.max() == pytest.approx(13.2, rel=0.02)


def test_lipschitz_needs_duty_below_0_2777_and_slope_does_not(car: Model) -> None:
    """The reason names the number; the slope restriction has no such bound."""
    form = relative_form(car)
    output = force_output(form)
    (reason,) = violated(form, output, Spec(sector=LIPSCHITZ))
    assert "0.2777" in reason
    assert "-3.6004" in reason
    assert violated(form, output, Spec(sector=LIPSCHITZ, rho=(0.0, 0.277))) == []
    assert violated(form, output, Spec(sector=SLOPE)) == []


def test_thesis_state_cannot_beat_root_two(car: Model) -> None:
    """With the printed C_z the road's velocity shows as sqrt(2), so gamma = 1.0001 is refused."""
    form = linearise(car)
    output = state_output(form, ("z_def", "v_s", "v_us", "f_y"))
    assert road_blind_gain(form, output, Spec()) == pytest.approx(np.sqrt(2.0), rel=1e-9)
    (reason,) = violated(form, output, Spec(gamma_max=1.0001))
    assert "1.4142" in reason
    assert "invariant zero" in reason
    relative = relative_form(car)
    assert road_blind_gain(relative, force_output(relative), Spec()) == 0.0


def test_unknown_input_can_be_decoupled(car: Model) -> None:
    """rank(C D1) = rank(D1) = 1 in both coordinates."""
    assert decoupling_ranks(linearise(car)) == (1, 1)
    assert decoupling_ranks(relative_form(car)) == (1, 1)


def test_what_no_output_shows_is_named(car: Model) -> None:
    """Without any sensor the tyre deflection, which the road moves freely, is lost."""
    form = relative_form(car)
    blind = replace(form, C=np.zeros_like(form.C))
    assert undetectable(form) == []
    assert undetectable(blind) == [0.0]
    assert any("show in no output" in text for text in violated(blind, force_output(form), Spec()))


def condition_needed(
    form: LinearForm, output: Output, spec: Spec, scaling: Scaling, rho: float
) -> float:
    """Smallest condition of P (typical sizes) that the observer (4.5) needs at a duty."""
    s = scale(form, output, spec, scaling)
    return least_condition(s, luenberger_family(s.A, s.C, s.D1), spec.sector, rho)


def test_the_lipschitz_bound_needs_a_condition_without_bound(car: Model) -> None:
    """Below 0.2777 nothing forbids it, but every Lyapunov function is ever closer to singular; the slope's is not."""
    asked = make._asked(car, make.Wish(spec=Spec(sector=LIPSCHITZ, rho=(0.0, 0.25))))
    duties = (0.05, 0.1, 0.25, 0.27)
    needed = [condition_needed(*asked, rho) for rho in duties]
    assert needed == pytest.approx([3.98e3, 3.19e4, 9.14e6, 1.37e8], rel=0.01)
    assert needed[0] < RESOLVED < needed[1]  # 0.05 has a solution, 0.1 none that a solver finds
    form, output, spec, scaling = asked
    slope = replace(spec, sector=SLOPE)
    found = [condition_needed(form, output, slope, scaling, rho) for rho in duties]
    assert max(found) < 6.0


def test_every_solution_has_the_condition_it_needs(car: Model) -> None:
    """A lower bound: what the synthesis finds lies above, with the Lipschitz bound at 0.05 and with the slope."""
    for sector, rho in ((LIPSCHITZ, 0.05), (SLOPE, 1.0)):
        wish = make.Wish(spec=Spec(sector=sector, rho=(0.0, rho)))
        claim = make.solve("nlpv_polytopic", car, wish)
        x = claim.scaling.state
        condition = float(np.linalg.cond(claim.solution.P * x * x[:, None]))
        least = condition_needed(claim.form, claim.output, claim.spec, claim.scaling, rho)
        assert 1.0 < least < condition


@pytest.mark.parametrize("observer", ["nlpv_polytopic", "unified"])
def test_the_synthesis_names_the_condition(car: Model, observer: str) -> None:
    with pytest.raises(SynthesisFailed, match=r"condition number of \d[\d.e+]* or more"):
        make.solve(observer, car, make.Wish(spec=Spec(sector=LIPSCHITZ, rho=(0.0, 0.25))))
