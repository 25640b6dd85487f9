"""The polytopic theorem: its solution, its failures, and that both say why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from er_models.linear import linearise, relative_form
from er_models.model import Model
from er_models.scales import Scales
from er_observers.scaling import scaling_of
from er_observers.synthesis import nlpv_polytopic
from er_observers.synthesis.certify import Certificate
from er_observers.synthesis.make import Wish, synthesise
from er_observers.synthesis.proof import Claim, prove
from er_observers.synthesis.spec import (
    LIPSCHITZ,
    Spec,
    SynthesisFailed,
    force_output,
    state_output,
)


def solve(model: Model, spec: Spec) -> Claim:
    """Solution in relative coordinates for the force."""
    form = relative_form(model)
    return nlpv_polytopic.claim(form, force_output(form), spec, scaling_of(model, form))


def test_solution_for_the_whole_range_of_duty(synthesis: tuple[Claim, Certificate]) -> None:
    """Duty 0 to 1, comfortably feasible, poles inside the disc and all stable."""
    claim, certificate = synthesis
    s = claim.solution
    assert s.gamma == pytest.approx(1.615, rel=5e-3)
    assert s.optimum < s.gamma <= 1.051 * s.optimum
    assert np.abs(certificate.poles).max() < claim.spec.radius
    assert certificate.poles.real.max() < -10.0
    assert certificate.slowest == pytest.approx(-0.525, abs=0.005)


def test_slope_beats_lipschitz_where_both_have_solutions(car: Model) -> None:
    """Duty up to 0.05: the Lipschitz form pays more than a hundredfold."""
    spec = Spec(rho=(0.0, 0.05), noise=(0.05, 0.5))
    slope, lipschitz = solve(car, spec), solve(car, replace(spec, sector=LIPSCHITZ))
    for claim in (slope, lipschitz):
        assert prove(claim)[1] == ""
    assert lipschitz.solution.gamma > 50.0 * slope.solution.gamma


def test_lipschitz_above_the_bound_fails_with_the_number(car: Model) -> None:
    """The reason is found before the solver is asked."""
    with pytest.raises(SynthesisFailed, match=r"needs rho below 0\.2777") as failure:
        solve(car, Spec(sector=LIPSCHITZ))
    assert failure.value.solver_status == "not asked"
    assert "\n" not in str(failure.value)


def test_thesis_claim_of_gamma_1_0001_is_refused(car: Model) -> None:
    """In absolute coordinates with the printed C_z."""
    form = linearise(car)
    output = state_output(form, ("z_def", "v_s", "v_us", "f_y"))
    spec = Spec(gamma_max=1.0001)
    with pytest.raises(SynthesisFailed, match=r"below 1\.4142"):
        nlpv_polytopic.claim(form, output, spec, scaling_of(car, form))


def test_what_is_too_tight_fails_with_the_solvers_word(car: Model) -> None:
    """No pole may be faster than 12 1/s: nothing known forbids it, but there is no solution."""
    with pytest.raises(SynthesisFailed) as failure:
        solve(car, Spec(radius=12.0))
    assert failure.value.solver_status != "not asked"
    with pytest.raises(SynthesisFailed, match=r"above the 0\.5 asked for"):
        solve(car, Spec(gamma_max=0.5))


def test_same_problem_same_gains(car: Model, synthesis: tuple[Claim, Certificate]) -> None:
    """Nothing random, no date: the bits agree."""
    again = solve(car, Spec())
    np.testing.assert_array_equal(again.solution.L, synthesis[0].solution.L)
    np.testing.assert_array_equal(again.solution.P, synthesis[0].solution.P)


def test_scaling_serves_a_real_car_as_well(car: Model) -> None:
    """A car of 315 kg a corner: same command, same kind of certificate."""
    effects = {name: dict(values) for name, values in car.effects.items()}
    effects["quarter_car"] = {"m_s": 315.0, "m_us": 37.5, "k_s": 29500.0, "k_t": 210000.0}
    effects["passive"] = {"k0": 5000.0, "c0": 1500.0}
    effects["guo_yield"] = {"f_c": 900.0, "k1": 60.0, "c1": 100.0}
    effects["response"] = {"tau": 0.015}
    real = replace(car, effects=effects, scales=Scales(1500.0, 0.08, 1.0, 1.0))
    claim, certificate = synthesise("nlpv_polytopic", real, Wish(force=300.0))
    assert claim.solution.gamma < 1.0
    assert certificate.margins.smallest > 0.0
    assert certificate.run.decay > 0.0
