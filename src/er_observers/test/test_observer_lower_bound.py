"""A gamma that no gain goes below: near the optimum, of the very inequalities, and refused when the proof is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from er_models.exact import exact
from er_models.model import Model
from er_observers.synthesis import lmi, lower_bound, nlpv_polytopic
from er_observers.synthesis.make import Wish, _asked, least_gamma
from er_observers.synthesis.scaled import scale
from er_observers.synthesis.spec import LIPSCHITZ, Spec


@pytest.fixture(scope="module")
def problem(car: Model) -> lmi.Problem:
    """The polytopic observer as it is shipped."""
    return nlpv_polytopic.problem(*_asked(car, Wish()))


def test_the_optimum_is_shut_in(problem: lmi.Problem) -> None:
    """From above by the proof of the gains, from below by this one."""
    optimum = lmi.smallest(problem)
    assert 0.98 * optimum < lower_bound.lower_bound(problem) < optimum


def test_gridding_and_the_unified_observer(car: Model) -> None:
    """A Lyapunov function of the duty does not help at the far end; the unified one has no interior."""
    assert least_gamma("nlpv_gridding", car, Wish()) == pytest.approx(1.5228, abs=0.002)
    assert least_gamma("unified", car, Wish()) is None


@pytest.mark.parametrize("sector", [Spec().sector, LIPSCHITZ])
def test_the_inequalities_are_those_of_the_synthesis(problem: lmi.Problem, sector) -> None:
    """Both are written by themselves; at random unknowns they are one."""
    p = replace(problem, spec=replace(problem.spec, sector=sector))
    posed, random = lmi._pose(p), np.random.default_rng(3)
    P = random.normal(size=(4, 4))
    P, Y, m = P + P.T, random.normal(size=(2, 4, 2)), random.normal(size=2)
    posed.v.P[0].value, posed.v.gamma_2.value, posed.v.t.value = P, 2.0, 0.0
    for k in range(2):
        posed.Y[k].value, posed.v.multipliers[k].value = Y[k], m[k : k + 1, None]
    wanted = [-c.args[0].value for k in range(2) for c in posed.constraints[4 * k + 2 : 4 * k + 4]]
    s = scale(p.form, p.output, p.spec, p.scaling)
    point = lower_bound._Point(*(exact(v) for v in (2.0, P, Y, m)))
    found = lower_bound._blocks(p.spec, s, p.family(s.A, s.C, s.D1), p.nodes, point)
    for a, b in zip(found, wanted, strict=True):
        assert a.astype(float) == pytest.approx(b, rel=1e-9, abs=1e-9)


def test_multipliers_outside_the_cone_prove_nothing(problem: lmi.Problem) -> None:
    p = problem
    s = scale(p.form, p.output, p.spec, p.scaling)
    columns = lower_bound._columns(p.spec, s, p.family(s.A, s.C, s.D1), p.nodes, False)
    rows, sizes = (
        np.array([lower_bound._stacked(c) for c in columns]),
        [len(b) for b in columns[0]],
    )
    Z, inside = lower_bound._proposal(rows.astype(float), sizes)
    assert lower_bound._proved(rows, Z, sizes, inside) > 0
    turned = [Z[0], Z[1] - 2.0 * inside * np.eye(8), *Z[2:]]
    assert lower_bound._proved(rows, turned, sizes, inside) == 0
    moved = [Z[0] + 1e-3 * np.eye(8), *Z[1:]]  # inside, but the equations no longer nearly hold
    assert lower_bound._proved(rows, moved, sizes, inside) == 0
