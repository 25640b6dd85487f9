"""The unified observer: its identities, its special cases, and where it cannot exist."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from er_models.model import Model
from er_observers.forms import form_of
from er_observers.scaling import scaling_of
from er_observers.synthesis import unified
from er_observers.synthesis.make import Wish, solve
from er_observers.synthesis.proof import Claim, prove
from er_observers.synthesis.spec import Spec, SynthesisFailed, force_output
from er_observers.synthesis.sweep import peak_gain
from er_observers.synthesis.vertices import vertex_gain


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


def test_dissipation_holds_along_random_errors(claims: dict[str, Claim]) -> None:
    """The inequality proved is the one meant, with what the noise adds to estimate and gate at once."""
    random = np.random.default_rng(0)
    for claim in claims.values():
        f, s, spec, law = claim.form, claim.solution, claim.spec, claim.solution.law
        for _ in range(300):
            rho, slope = random.uniform(size=2)
            M, J = law.at(rho)
            zeta, w = claim.sizes * random.normal(size=law.order), random.normal(size=3)
            w *= 10.0 ** random.uniform(-2, 3)
            noise = spec.noise_matrix() @ w
            error = law.R @ zeta - law.S @ noise
            gate = law.T @ f.B * rho * slope * (f.Gamma @ error)
            rate = M @ zeta + gate + law.T @ spec.input_matrix(f) @ w - J @ noise
            stored = 2.0 * zeta @ s.P @ rate
            supplied = s.gamma**2 * w @ w - np.sum((claim.output.rows @ error) ** 2)
            assert stored < supplied


def test_bounds_from_both_sides(claims: dict[str, Claim]) -> None:
    """Sweep below uncertain slopes below the proved gamma; nothing of it knows the structure."""
    claim = claims["proportional"]
    assert peak_gain(claim).gain < vertex_gain(claim) < claim.solution.gamma


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
        unified.claim(blind, force_output(blind), spec, scaling_of(car, blind))


def test_the_unified_law_is_constant() -> None:
    """As docs/observers.md says: both ends of the duty have one gain, and the dynamic states are coupled to nothing."""
    from pathlib import Path

    from er_models.gain_file import read

    file = read(Path(__file__).resolve().parents[3] / "config/gains/unified.yaml")
    m, j = file.matrix("law.M", (2, 8, 8)), file.matrix("law.J", (2, 8, 2))
    assert np.array_equal(m[0], m[1])
    assert np.array_equal(j[0], j[1])
    assert max(np.abs(m[0][:4, 4:]).max(), np.abs(m[0][4:, :4]).max()) < 1e-9 * np.abs(m[0]).max()
    assert np.abs(j[0][4:]).max() < 1e-9 * np.abs(j[0]).max()
