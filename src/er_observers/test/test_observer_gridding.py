"""The gridding theorem: proved between its grid points, for changing and for jumping duties."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from er_models.model import Model
from er_observers.forms import form_of
from er_observers.law import luenberger
from er_observers.running.ready import ready
from er_observers.scaling import scaling_of
from er_observers.synthesis import lmi, nlpv_gridding
from er_observers.synthesis.family import luenberger_family
from er_observers.synthesis.proof import Claim, gaps, prove
from er_observers.synthesis.spec import Spec, SynthesisFailed, force_output
from er_observers.synthesis.vertices import vertex_gain


@pytest.fixture(scope="module")
def claim(car: Model, gain_file: Path) -> Claim:
    """The committed gains."""
    return ready(gain_file.parent / "nlpv_gridding.yaml", car, "nlpv_gridding").claim


def test_proved_for_every_duty_and_both_kinds_of_change(claim: Claim) -> None:
    """P(rho) for a bounded rate, a common P for jumps; no worse than the polytopic observer."""
    assert prove(claim)[1] == ""
    s = claim.solution
    assert s.rate == 200.0
    assert np.linalg.norm(s.P_1) > 0.01 * np.linalg.norm(s.P)
    assert s.optimum == pytest.approx(1.538, rel=2e-3)
    assert claim.common is not None
    assert not np.any(claim.common.P_1)


def test_both_signs_of_the_rate_matter(claim: Claim) -> None:
    """A hundredfold rate is not proved by the same function."""
    faster = replace(claim, solution=replace(claim.solution, rate=2e4), common=None)
    assert "dissipation" in prove(faster)[1]


def test_the_middle_of_two_grid_points_is_looked_at(claim: Claim) -> None:
    """A function that holds at all grid points and fails between them is refused there."""
    s = claim.solution
    law = s.law
    L = law.J.copy()
    L[5] *= 3.0
    spoilt = replace(s, law=luenberger(claim.form, law.rho, L))
    margins, failed = prove(replace(claim, solution=spoilt, common=None))
    assert "rho = " in failed
    assert len(margins.dissipation) == 2 * (2 * len(law.rho) - 1)


def test_the_grid_grows_where_its_middles_ask_for_it(car: Model) -> None:
    """Three points are not enough for gains that are free at each; the inequalities hold after all."""
    form, spec = form_of(car), Spec()
    asked = (form, force_output(form), spec, scaling_of(car, form))
    alone = Claim(*asked, nlpv_gridding.solve(*asked, points=3, degree=None))
    assert gaps(alone) != []
    assert "rho = " in prove(alone)[1]
    grown = nlpv_gridding.claim(*asked, points=3, degree=None)
    assert len(grown.solution.law.rho) > 3
    assert gaps(grown) == []
    assert prove(grown)[1] == ""


def test_least_squares_fit_costs_gamma(claim: Claim) -> None:
    """(4.44) gives another gain, worse by a third and more; the direct one needs no fit."""
    s = claim.solution
    law = nlpv_gridding.straight(claim.form, *nlpv_gridding.fitted(claim.form, s), s.law.rho)
    fitted = vertex_gain(replace(claim, solution=replace(s, law=law), common=None))
    assert fitted > 1.3 * vertex_gain(claim)


def test_slope_as_uncertainty_finds_the_same_gamma(claim: Claim) -> None:
    """The LFT treatment and the sector agree; the Lipschitz bound has no solution at all."""
    slopes = vertex_gain(claim)
    assert 0.99 * claim.solution.optimum < slopes < 1.01 * claim.jumping.gamma
    with pytest.raises(SynthesisFailed):
        vertex_gain(claim, low=-1.0)


def test_a_second_solver_agrees(claim: Claim) -> None:
    """SCS, a first-order method: it proves 1.2 times the optimum and finds no margin at 0.8."""
    spec = Spec(noise=(0.5, 0.5), radius=500.0)
    asked = lmi.Problem(
        "second solver", claim.form, claim.output, spec, claim.scaling, luenberger_family,
        np.array([0.0, 1.0]),
    )  # fmt: skip
    optimum = lmi.solve(asked).optimum
    second = replace(asked, solver="SCS")
    found = lmi.widest(second, 1.2 * optimum)
    assert prove(Claim(claim.form, claim.output, spec, claim.scaling, found))[1] == ""
    with pytest.raises(SynthesisFailed, match="no margin"):
        lmi.widest(second, 0.8 * optimum)
