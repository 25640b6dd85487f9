"""What a synthesis is: a linear form and a Spec go in, a Solution or SynthesisFailed comes out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from er_models.errors import ErError
from er_models.forms.nlpv import noise_matrix
from er_models.linear import LinearForm
from er_models.model import Array

from er_observers.law import Law


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
SECTORS = {sector.name: sector for sector in (SLOPE, LIPSCHITZ)}


@dataclass(frozen=True, eq=False)
class Output:
    """Performance output ``rows e``, rows (p, n) divided by the sizes that count as one."""

    name: str
    rows: Array


def force_output(form: LinearForm, unit: float = 5.0) -> Output:
    """The damper force, in units of `unit` [N]: what the observer is for."""
    return Output("force", form.F[None, :] / unit)


def every_state(unit: Array) -> Output:
    """All states, in units (n,) [SI]."""
    return Output("states", np.diag(1.0 / unit))


def state_output(form: LinearForm, states: Sequence[str]) -> Output:
    """Named states in SI units, as the C_z of (4.3)."""
    chosen = [form.states.index(s) for s in states]
    return Output("states " + ", ".join(states), np.eye(form.n)[chosen])


@dataclass(frozen=True, eq=False)
class Spec:
    """What the gains must do.

    rho: range of the duty. noise (m,): outputs that count as one [m/s2], a deflection in m.
    unknown_input: rate of the unknown input that counts as one [m/s]. Region of every pole, the
    gate open wide: radius [1/s] of a disc, decay [1/s] at least, damping ratio at least. slack:
    how far above the optimum gamma may end for the sake of margins. gamma_max: refuse anything
    above.

    The noise is a design weight, not the sensor's: a heavy weight on the unsprung acceleration,
    which carries the road, gave the smallest errors with wrong parameters, biased sensors and a
    hidden friction (docs/observers.md).
    """

    sector: Sector = SLOPE
    rho: tuple[float, float] = (0.0, 1.0)
    noise: tuple[float, ...] = (0.05, 8.0)
    unknown_input: float = 1.0
    radius: float = 8000.0
    decay: float = 0.0
    damping: float = 0.0
    slack: float = 1.05
    gamma_max: float = float("inf")

    def input_matrix(self, form: LinearForm) -> Array:
        """Weighted unknown input and no noise: (n, 1 + outputs)."""
        quiet = np.zeros((form.n, len(self.noise)))
        return np.column_stack([form.D1 * self.unknown_input, quiet])

    def noise_matrix(self) -> Array:
        """Weighted noise on each output: (outputs, 1 + outputs)."""
        return noise_matrix(self.noise)


@dataclass(frozen=True, eq=False)
class Solution:
    """What a theorem returns, in SI units: a law, and the Lyapunov function that proves it.

    law: nodes K, order N. P, P_1 (N, N): V = z' (P + rho P_1) z, for duties that change by no more
    than `rate` [1/s] where P_1 is not zero. multipliers (K,) of the sector at the nodes, on
    straight lines between. gamma: proved; optimum: the smallest that the solver found.
    """

    law: Law
    P: Array
    P_1: Array
    rate: float
    multipliers: Array
    gamma: float
    optimum: float
    solver_status: str

    @property
    def L(self) -> Array:
        """Gains (K, N, m) of the law: those of a Luenberger observer."""
        return self.law.J

    def gain(self, rho: float) -> Array:
        """Gain (N, m) at a duty."""
        return self.law.at(rho)[1]

    def storage(self, rho: float) -> Array:
        """P + rho P_1 (N, N)."""
        return np.asarray(self.P + rho * self.P_1)
