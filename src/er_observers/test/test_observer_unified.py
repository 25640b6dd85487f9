"""The unified observer: its identities, its special cases, and where it cannot exist."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from er_models.model import Model
from er_observers.forms import form_of
from er_observers.synthesis import unified
from er_observers.synthesis.certify import certify
from er_observers.synthesis.make import Wish, solve
from er_observers.synthesis.proof import Claim, prove
from er_observers.synthesis.scaling import scaling_of
from er_observers.synthesis.spec import Spec, SynthesisFailed, force_output


@pytest.fixture(scope="module")
def claims(car: Model) -> dict[str, Claim]:
    """The full observer and its special cases."""
    names = ("full", "proportional", "integral")
    return {name: solve("unified", car, Wish(structure=name)) for name in names}


def test_conditions_of_the_lemma_hold(claims: dict[str, Claim]) -> None:
    """(3.8) to (3.12): for every structure, and the check sees a gain that is a little off."""
    for claim in claims.values():
        law, size = claim.solution.law, claim.scaling.state
        assert law.residual(claim.form, size) < 1e-10
        assert np.abs(law.T @ claim.form.D1).max() < 1e-9 * np.abs(law.T).max()
        assert replace(law, J=1.001 * law.J).residual(claim.form, size) > 1e-5


def test_special_cases_have_their_structure(claims: dict[str, Claim]) -> None:
    """(3.5) has no v; in (3.6) v is the integral of y - C x^."""
    n, m = 4, 2
    orders = {name: claim.solution.law.order for name, claim in claims.items()}
    assert orders == {"full": 2 * n, "proportional": n, "integral": n + m}
    law, C = claims["integral"].solution.law, claims["integral"].form.C
    np.testing.assert_allclose(law.M[0][n:, :n], -C @ law.R[:, :n], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(law.J[0][n:], np.eye(m) - C @ law.S, rtol=1e-9, atol=1e-12)
    assert not np.any(law.M[0][n:, n:])


def test_all_are_proved_and_the_dynamic_part_gains_nothing(claims: dict[str, Claim]) -> None:
    """The optimum of the full observer is that of the proportional one."""
    assert all(prove(claim)[1] == "" for claim in claims.values())
    optimum = {name: claim.solution.optimum for name, claim in claims.items()}
    assert optimum["full"] == pytest.approx(optimum["proportional"], rel=1e-3)
    assert optimum["full"] == pytest.approx(1.3656, rel=2e-3)
    assert optimum["full"] < optimum["integral"] < 1.05 * optimum["full"]


def test_certificate_of_the_special_cases(claims: dict[str, Claim]) -> None:
    """Nothing in the certificate knows the structure."""
    certificate = certify(claims["proportional"], "proportional")
    assert certificate.peak.gain < certificate.slopes < claims["proportional"].solution.gamma
    assert certificate.run.decay > 0.0


def test_absolute_velocities_leave_a_pole_at_zero(car: Model) -> None:
    """The reason is the invariant zero, found without a solver."""
    with pytest.raises(SynthesisFailed, match=r"invariant zero s = -?0") as failure:
        solve("unified", car, Wish(coordinates="absolute"))
    assert failure.value.solver_status == "not asked"


def test_rank_condition(car: Model) -> None:
    """Without the unsprung sensor the road cannot be decoupled, (3.33)."""
    form = form_of(car)
    blind = replace(form, C=form.C[:1])
    spec = Spec(noise=(0.05,))
    with pytest.raises(SynthesisFailed, match=r"rank\(C D1\) = 0, rank\(D1\) = 1"):
        unified.solve(blind, force_output(blind), spec, scaling_of(car, blind))
