r"""The closed loop on the Lipschitz form (2.11), compiled: hundreds of rides for tables and tuning.

x' = A x + B u tanh(Gamma x) + D_1 z_r', by the midpoint rule at the integrator's steps; what it leaves of
`er_models.simulation`, which is stiff and implicit, a test holds. Sensors as of `closed_loop.Sensors`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from er_ftc_controller.control import Faults, Ftc, Sample
from er_models.constants import SAMPLE_TIME as DT
from er_models.forms.lipschitz import LinearForm, linearise
from er_models.forms.loss import Factors, damaged
from er_models.model import Array, Model
from er_models.static_damper import HEALTHY

from er_ftc_controller import control
from er_studies.control.closed_loop import Sensors
from er_studies.control.form_loop import advance, ridden
from er_studies.control.measures import weighted


@dataclass(frozen=True, eq=False)
class Ridden:
    """A car with a fault from the start, the healthy one that is believed in; greatest duty, latency in samples."""

    model: Model
    left: Factors = HEALTHY
    u_max: float = 1.0
    latency: int = 0

    @cached_property
    def form(self) -> LinearForm:
        """The faulty car."""
        return linearise(damaged(self.model, self.left))

    @cached_property
    def matrices(self) -> tuple[Array, Array, Array, Array]:
        """A (5, 5); B, D_1, Gamma; accelerations and force, in rows (3, 5) each; belief: m_s, m_us, k_t, lag, full."""
        f, healthy, car = self.form, linearise(self.model), self.model.effects["quarter_car"]
        lag = -float(healthy.A[4, 4])
        belief = np.array([car["m_s"], car["m_us"], car["k_t"], lag, healthy.B[4] / lag])
        return f.A, np.array([f.B, f.D1, f.Gamma]), np.vstack([f.C, f.F]), belief


def noise_of(samples: int, seed: int, sensors: Sensors = Sensors()) -> Array:  # noqa: B008
    """Errors of both accelerations, deflection and velocity (n, 4)."""
    sizes = (sensors.acceleration,) * 2 + (sensors.deflection, sensors.velocity)
    return np.asarray(np.random.default_rng([seed, 7]).standard_normal((samples, 4)) * sizes)


def ride_peer(of: Ridden, road: Array, number: int, p: Array, seed: int) -> Array:
    """Record (n, 5) of a peer: deflection, body acceleration, tyre deflection, damper force, duty."""
    rates = _rates(road)
    noise = noise_of(len(rates) + 1, seed)
    return ridden(
        number, np.ascontiguousarray(p, float), *of.matrices, rates, noise, of.u_max, of.latency
    )  # type: ignore[no-any-return]


def ride_ours(of: Ridden, road: Array, ftc: Ftc, seed: int, *, told: bool = True) -> Array:
    """The same of the controller, told the fault or not."""
    A, inputs, outputs, _ = of.matrices
    rates, q = _rates(road), np.zeros(5)
    noise = noise_of(len(rates) + 1, seed)
    out, mind, acting, pending = np.empty((len(noise), 5)), control.start(ftc), 0.0, 0.0
    left = (of.left.electrical, of.left.leakage, of.left.deformation)
    for k in range(len(noise)):
        if k:
            advance(A, inputs, q, rates[k - 1], acting)
        a_s, a_us, force = outputs @ q
        if told and not k % 20:
            mind = control.hear(
                ftc, mind, Faults(k * DT, *left, certain=min(left) < 1.0, usable=True)
            )
        read = np.array([q[0], q[1] - q[3], a_s, a_us]) + noise[k][[2, 3, 0, 1]]
        mind, command = control.step(ftc, mind, k * DT, Sample(*read.tolist()))
        acting, pending = (pending, command.duty) if of.latency else (command.duty, 0.0)
        out[k] = q[0], a_s, q[2], force, acting
    return out


def measured(record: Array, model: Model, begin: float) -> Array:
    """Deflection [m], comfort [m/s2], tyre load [N] and damper force [N] of a record from a time [s] on, rms (4,)."""
    rows = record[round(begin / DT) :]
    felt = weighted(record[:, 1], DT)[round(begin / DT) :]
    values = (rows[:, 0], felt, model.value("quarter_car", "k_t") * rows[:, 2], rows[:, 3])
    return np.array([float(np.sqrt(np.mean(v**2))) for v in values])


def _rates(road: Array) -> Array:
    """Rates of the road [m/s] in each line of each sample (n, lines)."""
    from er_models.simulation import substeps

    lines = substeps(DT)
    return np.ascontiguousarray(np.diff(road).reshape(-1, lines) * (lines / DT))
