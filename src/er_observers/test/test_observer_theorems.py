"""Every name of a theorem leads to that theorem, and to everything else an observer needs."""

from __future__ import annotations

from pathlib import Path

import pytest
from er_models.errors import ErError, UnknownName
from er_models.model import Model
from er_observers.synthesis import make
from er_observers.synthesis.lmi import Problem
from er_observers.synthesis.make import THEOREMS, Wish
from er_observers.synthesis.proof import Claim, prove
from er_observers.synthesis.spec import LIPSCHITZ, Spec, SynthesisFailed


def written_down(claim: Claim) -> tuple[int, int, bool, bool]:
    """What tells claims apart: order of the law, its nodes, whether P moves, whether there is a common one."""
    s = claim.solution
    return s.law.order, len(s.law.rho), bool(s.P_1.any()), claim.common is not None


SHAPES = {
    "unified": (8, 2, False, False),
    "nlpv_polytopic": (4, 2, False, False),
    "nlpv_gridding": (4, 11, True, True),
}


@pytest.mark.parametrize("name", THEOREMS)
def test_a_name_leads_to_its_own_theorem(car: Model, name: str) -> None:
    """Feasible with the default wish and proved; the file's own inequalities for trade-off and lower bound."""
    claim = make.solve(name, car, Wish())
    assert prove(claim)[1] == ""
    assert written_down(claim) == SHAPES[name]
    problem = make._problem(name, car, Wish())
    assert isinstance(problem, Problem)
    assert problem.theorem == THEOREMS[name].THEOREM


@pytest.mark.parametrize("name", THEOREMS)
def test_its_own_theorem_says_why_there_are_no_gains(car: Model, name: str) -> None:
    """The Lipschitz bound at every duty: no gain of any structure meets it."""
    with pytest.raises(SynthesisFailed, match=r"needs rho below 0\.2777") as failure:
        make.solve(name, car, Wish(Spec(sector=LIPSCHITZ)))
    assert failure.value.theorem == THEOREMS[name].THEOREM


def test_an_unknown_name_is_no_other_theorem(car: Model) -> None:
    for asked in (make.solve, make.trade_off, make.least_gamma, make.synthesise):
        with pytest.raises(UnknownName, match=r"unknown observer 'nlpv_polytope'; did you mean"):
            asked("nlpv_polytope", car, Wish())


def test_special_cases_are_those_of_the_unified_observer(car: Model) -> None:
    """Asked of another they are refused, not left out."""
    with pytest.raises(ErError, match="structure: expected full for nlpv_polytopic"):
        make.solve("nlpv_polytopic", car, Wish(structure="integral"))


@pytest.mark.parametrize("name", THEOREMS)
def test_every_theorem_has_its_gains(gain_file: Path, name: str) -> None:
    """The steps of CONTRIBUTING.md; those of the node are those of every node (test_nodes)."""
    assert (gain_file.parent / f"{name}.yaml").is_file()
