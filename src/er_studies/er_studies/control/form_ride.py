r"""The closed loop on the Lipschitz form (2.11), compiled: hundreds of rides for tables and tuning.

x' = A x + B u tanh(Gamma x) + D_1 z_r', by the midpoint rule at the integrator's steps; what it leaves of
`er_models.simulation`, which is stiff and implicit, a test holds. Sensors as of `closed_loop.Sensors`.
"""

from __future__ import annotations

import math
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
from er_studies.control.measures import weighted
from er_studies.control.peers import duty
from er_studies.control.peers.sample import (
    A_S,
    A_U,
    AHEAD,
    FORCE,
    FULL,
    GATE,
    STEP,
    TYRE,
    V_S,
    WAY,
    V,
    X,
    compiled,
)  # fmt: skip

LEAK = 2.0 * math.pi * 0.1
"""Corner of the leaky integral of all peers [rad/s]."""
PER_STEP = round(STEP / DT)


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
    return _peer(
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
            _advance(A, inputs, q, rates[k - 1], acting)
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


@compiled
def _advance(A: Array, inputs: Array, q: Array, rates: Array, u: float) -> None:
    """One sample of the car, in place."""
    h = DT / rates.size
    mid, slope = np.empty(5), np.empty(5)
    for rate in rates:
        for part in range(2):
            at = q if part == 0 else mid
            move = 0.0
            for j in range(5):
                move += inputs[2, j] * at[j]
            gate = u * math.tanh(move)
            for i in range(5):
                slope[i] = inputs[0, i] * gate + inputs[1, i] * rate
                for j in range(5):
                    slope[i] += A[i, j] * at[j]
            for i in range(5):
                if part == 0:
                    mid[i] = q[i] + 0.5 * h * slope[i]
                else:
                    q[i] += h * slope[i]


@compiled
def _peer(
    number: int, p: Array, A: Array, inputs: Array, outputs: Array, belief: Array, rates: Array, noise: Array,
    u_max: float, latency: int,
) -> Array:  # fmt: skip
    """The loop of a peer; sensors, what it follows, and its duty at each sample."""
    n, out, q, s = noise.shape[0], np.empty((noise.shape[0], 5)), np.zeros(5), np.zeros(10 + AHEAD)
    acting, pending, before, gate = 0.0, 0.0, 0.0, 0.0
    m_s, m_us, k_t, lag, full = belief
    kept, fades = math.exp(-DT * lag), math.exp(-DT * LEAK)
    time = 0.5 * DT + latency * DT
    s[FULL] = full
    for k in range(n):
        if k > 0:
            _advance(A, inputs, q, rates[k - 1], acting)
        a_s, a_us, force = 0.0, 0.0, 0.0
        for j in range(5):
            a_s += outputs[0, j] * q[j]
            a_us += outputs[1, j] * q[j]
            force += outputs[2, j] * q[j]
        s[A_S], s[A_U] = a_s + noise[k, 0], a_us + noise[k, 1]
        s[X], s[V] = q[0] + noise[k, 2], q[1] - q[3] + noise[k, 3]
        s[V_S] = s[V_S] * fades + 0.5 * DT * (before + s[A_S])
        before = s[A_S]
        s[TYRE] = -(m_s * s[A_S] + m_us * s[A_U]) / k_t
        now = math.tanh(inputs[2, 0] * s[X] + inputs[2, 1] * s[V])
        s[FORCE] = s[FORCE] * kept + (1.0 - kept) * full * acting * 0.5 * (gate + now)
        gate, rate = now, s[A_S] - s[A_U]
        s[GATE] = math.tanh(
            inputs[2, 0] * (s[X] + time * (s[V] + 0.5 * time * rate))
            + inputs[2, 1] * (s[V] + time * rate)
        )
        for i in range(AHEAD):
            first = k + i * PER_STEP
            s[WAY + i] = (
                rates[first : first + PER_STEP].mean() if first + PER_STEP <= n - 1 else 0.0
            )
        wish = duty(number, p, s, u_max)
        if latency > 0:
            acting, pending = pending, wish
        else:
            acting = wish
        out[k, 0], out[k, 1], out[k, 2], out[k, 3], out[k, 4] = q[0], a_s, q[2], force, acting
    return out
