"""The certificate: it holds for good gains, and each of its parts can fail."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from er_models.model import Model
from er_observers.law import luenberger
from er_observers.observers.gate import mean_gate
from er_observers.observers.kernel import SUBSTEP
from er_observers.synthesis.certify import Certificate, certify
from er_observers.synthesis.discrete import error_map, lens, step_storage, substep
from er_observers.synthesis.make import Wish, solve, synthesise
from er_observers.synthesis.proof import Claim, prove
from er_observers.synthesis.spec import Solution, Spec, SynthesisFailed

Made = tuple[Claim, Certificate]


def changed(claim: Claim, **parts: object) -> Claim:
    """The claim with other parts of its solution; L: with other gains."""
    if "L" in parts:
        parts["law"] = luenberger(claim.form, claim.solution.law.rho, parts.pop("L"))  # type: ignore[arg-type]
    return replace(claim, solution=replace(claim.solution, **parts))  # type: ignore[arg-type]


def spoilt(s: Solution, name: str) -> dict[str, object]:
    """One way of breaking a solution."""
    one = np.zeros_like(s.P)
    one[0, 0] = s.P[0, 0]
    ways: dict[str, dict[str, object]] = {
        "gain of the wrong sign": {"L": -s.L},
        "one entry lost": {"L": s.L * np.where(np.arange(16).reshape(2, 4, 2) == 10, 0.0, 1.0)},
        "gamma below the optimum": {"gamma": 0.98 * s.optimum},
        "P indefinite": {"P": s.P - 2.0 * one},
        "P too small": {"P": 0.1 * s.P},
        "multiplier lost": {"multipliers": s.multipliers * np.array([1.0, 1e-3])},
        "multiplier negative": {"multipliers": -s.multipliers},
    }
    return ways[name]


def test_proof_holds_with_margins(synthesis: Made) -> None:
    """Nothing fails, and every margin is positive in scaled coordinates."""
    margins, failed = prove(synthesis[0])
    assert failed == ""
    assert margins.smallest > 1e-6
    assert min(margins.dissipation) > 1e-4


@pytest.mark.parametrize(
    "way",
    [
        "gain of the wrong sign",
        "one entry lost",
        "gamma below the optimum",
        "P indefinite",
        "P too small",
        "multiplier lost",
        "multiplier negative",
    ],
)
def test_proof_fails_for_spoilt_solutions(synthesis: Made, way: str) -> None:
    """Whatever is broken, an inequality is named."""
    claim = synthesis[0]
    _, failed = prove(changed(claim, **spoilt(claim.solution, way)))
    assert failed
    with pytest.raises(SynthesisFailed, match=r"no proof|has a pole"):
        certify(changed(claim, **spoilt(claim.solution, way)), "theorem")


def test_dissipation_holds_along_random_errors(synthesis: Made) -> None:
    """The inequality proved is the one meant: checked term by term for random e, d, w and rho."""
    claim, _ = synthesis
    f, s, spec = claim.form, claim.solution, claim.spec
    random = np.random.default_rng(0)
    W, N = spec.input_matrix(f), spec.noise_matrix()
    for _ in range(500):
        rho, slope = random.uniform(size=2)
        e = claim.scaling.state * random.normal(size=4)
        w = random.normal(size=3) * 10.0 ** random.uniform(-2, 2)
        L = s.gain(rho)
        rate = (f.A - L @ f.C) @ e + f.B * rho * slope * (f.Gamma @ e) + (W - L @ N) @ w
        stored = 2.0 * e @ s.P @ rate
        supplied = s.gamma**2 * w @ w - np.sum((claim.output.rows @ e) ** 2)
        assert stored < supplied


def test_sweep_stays_below_the_proved_gain(synthesis: Made) -> None:
    """The frozen gate gives a bound from below; it is not far below."""
    claim, certificate = synthesis
    assert 0.3 * claim.solution.gamma < certificate.peak.gain <= claim.solution.gamma


def test_mean_slopes_of_the_gate_lie_in_the_lens() -> None:
    """For random straight paths the two partial derivatives lie between the lens's two edges."""
    random, edge = np.random.default_rng(2), lens(400)
    below, above = edge[:400], edge[400:][np.argsort(edge[400:, 0])]
    sides = set()
    for _ in range(300):
        s_0, s_1 = random.normal(size=2) * 10.0 ** random.uniform(-1, 1.5)
        k_0, k_1 = mean_gate(s_1, s_0)[1], mean_gate(s_0, s_1)[1]
        assert np.interp(k_0, *below.T) - 1e-5 <= k_1 <= np.interp(k_0, *above.T) + 1e-5
        sides.add(bool(k_0 > k_1))
    assert sides == {True, False}


def test_discrete_observer_contracts_at_its_substep_only(synthesis: Made) -> None:
    """The substep in use is certified; twice as long is not, so the check can fail."""
    claim, certificate = synthesis
    assert certificate.run.decay > 0.3
    assert certificate.run.loop < 2.0
    assert certificate.wandering < 1.0
    with pytest.raises(SynthesisFailed, match="no Lyapunov function shrinks"):
        step_storage(claim, (2.0 * SUBSTEP,), certificate.slowest)


def test_every_grid_point_is_stable_by_itself(synthesis: Made) -> None:
    """Spectral radius below one over duty and slope, a check without the Lyapunov function."""
    claim, _ = synthesis
    for rho in np.linspace(0.0, 1.0, 11):
        law, e = claim.solution.law, claim.error
        linear, kick = substep(law.at(float(rho))[0], e.b[:, 0] * rho, SUBSTEP)
        for gate in lens(9):
            poles = np.linalg.eigvals(error_map(linear, kick, e.G[0], gate))
            assert np.abs(poles).max() < 1.0


@pytest.mark.parametrize(("region", "asked"), [("decay", 1.0), ("damping", 0.3)])
def test_poles_lie_where_they_were_asked_to(car: Model, region: str, asked: float) -> None:
    """The half-plane and the cone hold for the poles that are found, and no proof says more of them than is true."""
    spec = Spec(radius=1000.0, **{region: asked})  # type: ignore[arg-type]
    claim, _ = synthesise("nlpv_polytopic", car, Wish(spec=spec))
    poles = np.concatenate([np.linalg.eigvals(M) for M in claim.solution.law.M])
    found = {"decay": -poles.real.max(), "damping": (-poles.real / np.abs(poles)).min()}[region]
    assert found >= asked
    assert np.abs(poles).max() <= 1000.0
    boast = replace(claim, spec=replace(spec, **{region: 1.02 * float(found)}))
    assert prove(boast)[1]


def test_the_cone_is_as_wide_as_the_damping_asked_for(car: Model) -> None:
    """At the edge of the numerical range of the error dynamics in the norm of P, found by another way."""
    claim, _ = synthesise("nlpv_polytopic", car, Wish(spec=Spec(radius=1000.0, damping=0.3)))
    s = claim.solution
    root = np.linalg.cholesky(s.P + s.P_1 * s.law.rho[0]).T
    G = root @ s.law.M[0] @ np.linalg.inv(root)
    edge = []
    for angle in np.linspace(0.0, 2.0 * np.pi, 2000):
        turned = np.exp(1j * angle) * G
        x = np.linalg.eigh(turned + turned.conj().T)[1][:, -1]
        edge.append(x.conj() @ G @ x)
    least = float((-np.real(edge) / np.abs(edge)).min())
    assert 0.3 < least < 0.99

    def holds(damping: float) -> bool:
        asked = replace(claim, spec=replace(claim.spec, damping=damping))
        cone = asked.region(s, "cone", (0, 0), np.asarray)
        return bool(np.linalg.eigvalsh(0.5 * (cone + cone.T))[0] > 0.0)

    assert holds(0.98 * least)
    assert not holds(1.02 * least)


@pytest.mark.filterwarnings("error")
def test_where_no_substep_shrinks_the_line_says_which_grow_and_what_may_help(car: Model) -> None:
    """Without passive damping, no warning of a library; two substeps in turn grow, a smaller disc has a solution."""
    bare = car.with_effect("passive", {**car.effects["passive"], "c0": 0.0})
    steps = (0.5 * SUBSTEP, SUBSTEP)
    wide, small = (solve("nlpv_polytopic", bare, Wish(Spec(radius=r))) for r in (8000.0, 2000.0))
    says = r"in turn, .* grow by 1\.1\d* each; the fastest pole, \d+ 1/s, is 10 per .* smaller --radius .*8000 1/s"
    with pytest.raises(SynthesisFailed, match=says) as failed:
        step_storage(wide, steps, -0.5)
    assert "\n" not in str(failed.value)
    assert step_storage(small, steps, -0.5)[1].decay > 0.0
