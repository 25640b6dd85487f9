"""What a synthesis is: a linear form and a Spec go in, a Solution or SynthesisFailed comes out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from er_models.errors import ErError
from er_models.linear import LinearForm
from er_models.model import Array


class SynthesisFailed(ErError):
    """No gain was found or none could be proved; carries the reason and the solver's word."""

    exit_status = 1

    def __init__(self, theorem: str, reason: str, solver_status: str = "not asked") -> None:
        self.theorem, self.reason, self.solver_status = theorem, reason, solver_status
        super().__init__(f"{theorem}: {reason} (solver: {solver_status})")


@dataclass(frozen=True, eq=False)
class Sector:
    """What is known of the gate: ``[s, d] form [s, d]' >= 0``, form (2, 2) symmetric.

    s = Gamma e is the error at the gate's input, d = Phi(x) - Phi(x^) at its output.
    """

    name: str
    form: Array
    source: str


SLOPE = Sector(
    "slope",
    np.array([[0.0, 1.0], [1.0, -2.0]]),
    "0 <= d / s <= 1, so 2 d (s - d) >= 0: incremental circle criterion, Arcak & Kokotovic 2001",
)
LIPSCHITZ = Sector(
    "lipschitz", np.array([[1.0, 0.0], [0.0, -1.0]]), "|d| <= |s|: thesis (4.4), (4.16)"
)


@dataclass(frozen=True, eq=False)
class Output:
    """Performance output ``rows e``, rows (p, n) divided by the sizes that count as one."""

    name: str
    rows: Array


def force_output(form: LinearForm, unit: float = 5.0) -> Output:
    """The damper force, in units of `unit` [N]: what the observer is for."""
    return Output("force", form.F[None, :] / unit)


def state_output(form: LinearForm, states: Sequence[str]) -> Output:
    """Named states in SI units, as the C_z of (4.3)."""
    chosen = [form.states.index(s) for s in states]
    return Output("states " + ", ".join(states), np.eye(form.n)[chosen])


@dataclass(frozen=True, eq=False)
class Spec:
    """What the gains must do.

    rho: range of the duty. noise (2,): accelerations that count as one [m/s2]. unknown_input: rate
    of the unknown input that counts as one [m/s]. radius: bound of every pole [1/s]. slack: how
    far above the optimum gamma may end for the sake of margins. gamma_max: refuse anything above.

    The noise is a design weight, not the sensor's: a heavy weight on the unsprung acceleration,
    which carries the road, gave the smallest errors with wrong parameters, biased sensors and a
    hidden friction (docs/observers.md).
    """

    sector: Sector = SLOPE
    rho: tuple[float, float] = (0.0, 1.0)
    noise: tuple[float, ...] = (0.05, 8.0)
    unknown_input: float = 1.0
    radius: float = 4000.0
    slack: float = 1.05
    gamma_max: float = float("inf")

    def input_matrix(self, form: LinearForm) -> Array:
        """Weighted unknown input and no noise: (n, 1 + outputs)."""
        quiet = np.zeros((form.n, len(self.noise)))
        return np.column_stack([form.D1 * self.unknown_input, quiet])

    def noise_matrix(self) -> Array:
        """Weighted noise on each output: (outputs, 1 + outputs)."""
        return np.column_stack([np.zeros(len(self.noise)), np.diag(self.noise)])


@dataclass(frozen=True, eq=False)
class Solution:
    """What a theorem returns, in SI units: gains and the Lyapunov function that proves them.

    L (2, n, outputs), P (n, n), multipliers (2,) of the sector at the vertices.
    """

    L: Array
    P: Array
    multipliers: Array
    gamma: float
    optimum: float
    solver_status: str

    def gain(self, rho: float, spec: Spec) -> Array:
        """L(rho) (n, outputs), on the straight line between the vertices."""
        share = (rho - spec.rho[0]) / (spec.rho[1] - spec.rho[0])
        return np.asarray((1.0 - share) * self.L[0] + share * self.L[1])
