"""Certificate of a synthesis: every statement found again outside the solver.

It starts from the rounded gains in SI units, which are what will be written and run.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from er_models.model import Array

from er_observers.law import RESIDUAL
from er_observers.observers.kernel import SUBSTEP
from er_observers.observers.table import Table
from er_observers.synthesis.discrete import Contraction, looked_up, step_storage
from er_observers.synthesis.proof import Claim, Margins, prove
from er_observers.synthesis.spec import SynthesisFailed
from er_observers.synthesis.sweep import Peak, peak_gain
from er_observers.synthesis.vertices import vertex_gain
from er_observers.synthesis.wander import wandering

_NEARLY = 1.01
"""Two ways to one number, each with the accuracy of a solver."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """What was proved or measured of a claim.

    margins: of the inequalities, exact. peak: L2 gain with a frozen gate, below the proved gamma.
    slopes: L2 gain with the gate as an uncertain slope, a second way to the incremental gain;
    NaN where the solver gave no answer.
    poles (ends, n): of A - L C [1/s]. slowest: largest real part of a pole over duty and gate
    slope [1/s]. run: contraction of the discrete observer. wandering: the same along random
    duties, measured on the compiled kernel. table: the substeps that are looked up.
    """

    margins: Margins
    peak: Peak
    slopes: float
    poles: Array
    slowest: float
    run: Contraction
    wandering: float
    table: Table

    @property
    def figures(self) -> dict[str, Any]:
        """Plain values for a gain file, short enough to be the same on every machine."""
        return {
            "margins": {
                "lyapunov": _short(self.margins.lyapunov),
                "dissipation": _short(min(self.margins.dissipation)),
                "regions": _short(min(self.margins.regions)),
            },
            "sweep": {name: _short(value) for name, value in self.peak._asdict().items()},
            "slopes": plain(self.slopes),
            "poles": [[[_short(p.real), _short(p.imag)] for p in end] for end in self.poles],
            "slowest": _short(self.slowest),
            "discrete": {
                "substep": SUBSTEP,
                "decay": _short(self.run.decay),
                "rho": _short(self.run.rho),
                "duties": len(self.table.duties),
                "gap": _short(self.table.gap),
            },
            "random_scheduling": _short(self.wandering),
        }


def plain(value: float) -> float | None:
    """Five significant digits, None for infinity."""
    return _short(value) if np.isfinite(value) else None


def _short(value: float) -> float:
    """Five significant digits."""
    return float(f"{value:.5g}")


def certify(claim: Claim, theorem: str) -> Certificate:
    """Certificate of a claim; `SynthesisFailed` naming the first statement that does not hold."""
    solution = claim.solution

    def demand(reason: str, *, holds: bool) -> None:
        if not holds:
            raise SynthesisFailed(theorem, reason, solution.solver_status)

    slowest, law = _slowest(claim), solution.law
    reason = f"the law has a pole at {slowest:.3g} 1/s for some duty and slope of the gate"
    demand(reason, holds=slowest < 0.0)
    residual = law.residual(claim.form, claim.scaling.state)
    reason = f"the error is not free of the state: residual {residual:.3g}"
    demand(reason, holds=residual <= RESIDUAL)
    margins, failed = prove(claim)
    demand(f"the solver's answer is no proof: {failed}", holds=not failed)
    peak = peak_gain(claim)
    reason = f"the sweep finds a gain of {peak.gain:.4g}, above the proved {solution.gamma:.4g}"
    demand(reason, holds=peak.gain <= solution.gamma)
    slopes = vertex_gain(claim)
    reason = f"slopes of the gate ask for gamma {slopes:.4g}, above the proved {claim.jumping.gamma:.4g}"
    demand(reason, holds=not slopes > claim.jumping.gamma * _NEARLY)
    reason = f"the sweep finds a gain of {peak.gain:.4g}, slopes of the gate {slopes:.4g}"
    demand(reason, holds=not peak.gain > slopes * _NEARLY)
    steps = (0.5 * SUBSTEP, SUBSTEP)
    shrinking, run = step_storage(claim, steps, slowest)
    reason = f"the discrete observer does not converge at rho = {run.rho:.3g}: {run.decay:.4g} 1/s"
    demand(reason, holds=run.decay > 0.0 and run.loop < 2.0)
    roams = wandering(claim, shrinking)
    reason = f"two runs drift apart by {roams:.6f} per sample along random duties"
    demand(reason, holds=roams < 1.0)
    poles = [np.sort_complex(np.linalg.eigvals(M)) for M in solution.law.M]
    return Certificate(
        margins, peak, slopes, np.array(poles), slowest, run, roams, looked_up(claim)
    )


def _slowest(claim: Claim) -> float:
    """Largest real part of a pole of M + slope rho T B Gamma R, over duty and slope [1/s]."""
    law, e = claim.solution.law, claim.error
    worst = -np.inf
    for rho in np.linspace(law.rho[0], law.rho[-1], 11):
        M, _ = law.at(float(rho))
        for slope in np.linspace(0.0, 1.0, 11):
            poles = np.linalg.eigvals(M + slope * rho * e.b @ e.G)
            worst = max(worst, float(poles.real.max()))
    return float(worst)
