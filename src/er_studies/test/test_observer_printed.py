"""The thesis's own gains: refused by the certificates, with a number each; its gamma is a bound."""

from __future__ import annotations

import numpy as np
import pytest
from er_models.model import Model
from er_observers.forms import form_of
from er_observers.scaling import scaling_of
from er_observers.synthesis import lmi, unified
from er_observers.synthesis.certify import certify
from er_observers.synthesis.make import Wish, solve
from er_observers.synthesis.proof import Claim, prove
from er_observers.synthesis.spec import LIPSCHITZ, Solution, Spec, SynthesisFailed, state_output
from printed_gains import laws

GAMMAS = {"unified": 0.1270, "nlpv_polytopic": 1.0001, "nlpv_gridding": 1.4142}
Z_E = ("z_def", "v_s", "v_us", "f_y")


def printed(car: Model, name: str) -> Claim:
    """What the thesis claims of one observer: its law, its gamma, the Lipschitz bound, any pole."""
    form = form_of(car, "absolute")
    law, spec = laws(form)[name], Spec(LIPSCHITZ, noise=(0.01, 0.01), radius=1e9)
    one = np.eye(law.order)
    solution = Solution(
        law, one, 0.0 * one, 0.0, np.ones(2), GAMMAS[name], GAMMAS[name], "printed"
    )
    return Claim(form, state_output(form, Z_E), spec, scaling_of(car, form), solution)


@pytest.mark.parametrize("name", GAMMAS)
def test_printed_gains_are_refused(car: Model, name: str) -> None:
    """Each has a pole that does not decay; no Lyapunov function proves the Lipschitz form of any."""
    claim = printed(car, name)
    with pytest.raises(SynthesisFailed, match="the law has a pole at"):
        certify(claim, name)
    asked = lmi.Problem(
        name, claim.form, claim.output, claim.spec, claim.scaling, unified.unified_family,
        claim.solution.law.rho,
    )  # fmt: skip
    with pytest.raises(SynthesisFailed):
        lmi.analyse(asked, claim.solution.law)


def test_printed_gridding_gain_is_unstable_before_yield(car: Model) -> None:
    """At duty 1 and small motion, where the gate is a line of slope one."""
    claim = printed(car, "nlpv_gridding")
    loop = claim.solution.law.M[1] + claim.error.b @ claim.error.G
    assert np.linalg.eigvals(loop).real.max() == pytest.approx(19.9, abs=0.5)


def test_gamma_of_root_two_is_the_bound(car: Model) -> None:
    """Absolute velocities, the printed C_z, next to no field: the optimum is what no gain can beat."""
    spec = Spec(rho=(0.0, 0.001), noise=(0.05, 0.5))
    claim = solve("nlpv_polytopic", car, Wish(spec, "thesis", "absolute"))
    assert claim.solution.optimum == pytest.approx(np.sqrt(2.0), rel=1e-3)
    assert prove(claim)[1] == ""
