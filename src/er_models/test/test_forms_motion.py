"""The forms of chapter 2 in motion: SciPy solves each of them on rich roads and duties; all must agree.

The truth is the compiled nonlinear right-hand side. Each form is driven by its own inputs: the
road's height or rate, the rate of the tyre's deflection, the lost force.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from er_models.forms.descriptor import descriptor_form
from er_models.forms.lipschitz import linearise
from er_models.forms.loss import Factors, lost_force
from er_models.forms.lti import lti_form
from er_models.forms.nlpv import nlpv_form
from er_models.forms.passive import passive_response
from er_models.forms.qlpv import qlpv_form
from er_models.forms.relative import relative_form
from er_models.model import Array, Model
from er_models.simulation import simulate
from models_help import car as quarter_car
from models_help import exact_rates
from scipy.integrate import solve_ivp

TIMES = np.linspace(0.0, 0.8, 161)
TIGHT = {"method": "LSODA", "rtol": 1e-9, "atol": 1e-12}
CLOSE = 1e-6
"""Largest difference of two solutions, as a share of a signal's range."""

Rate = Callable[[float, Array], Array]


@dataclass(frozen=True)
class Drive:
    """A road of many sines [m] and a duty that jumps at the `edges` and wanders between them."""

    hertz: Array
    height: Array
    phase: Array
    edges: Array
    levels: Array
    sway: float

    def road(self, t: float, order: int = 0) -> float:
        """Height of the road or its derivative."""
        omega = 2.0 * np.pi * self.hertz
        start = np.sin(self.phase) if order == 0 else 0.0
        wave = omega**order * np.sin(omega * t + self.phase + 0.5 * np.pi * order)
        return float(self.height @ (wave - start))

    def duty(self, t: float, piece: int) -> float:
        """Duty within a piece between two edges."""
        return float(self.levels[piece] * (1.0 + self.sway * np.sin(2.0 * np.pi * 3.0 * t)) / 1.5)


def drive(seed: int, roughness: float, sway: float) -> Drive:
    """Twelve sines from 0.5 to 30 Hz with the spectrum of a road, duty between 0 and 1."""
    random = np.random.default_rng(seed)
    hertz = np.geomspace(0.5, 30.0, 12) * random.uniform(0.95, 1.05, 12)
    height = roughness / hertz**1.2 * random.uniform(0.5, 1.5, 12)
    edges = np.concatenate([[0.0], np.sort(random.uniform(0.05, 0.75, 5)), [TIMES[-1]]])
    levels = random.permutation([0.0, 0.2, 0.5, 0.8, 1.0, 1.0])
    return Drive(hertz, height, random.uniform(0, 2 * np.pi, 12), edges, levels, sway)


DRIVES = [
    pytest.param(drive(1, 0.004, 0.0), id="rough, held duty"),
    pytest.param(drive(3, 0.0002, 0.5), id="within the gate, wandering duty"),
]


def solved(rate_of: Callable[[int], Rate], start: Sequence[float], d: Drive) -> Array:
    """States (times, n) at `TIMES`; rate_of gives the right-hand side within a piece of the duty."""
    y, out = np.array(start, float), []
    for piece, (a, b) in enumerate(zip(d.edges[:-1], d.edges[1:], strict=True)):
        within = TIMES[np.searchsorted(TIMES, a) : np.searchsorted(TIMES, b)]
        found = solve_ivp(rate_of(piece), (a, b), y, t_eval=np.append(within, b), **TIGHT)
        out.append(found.y[:, :-1].T)
        y = found.y[:, -1]
    return np.vstack([*out, y[None]])


def duties(d: Drive) -> Array:
    """Duty at `TIMES`, the one held from each time on."""
    pieces = np.minimum(np.searchsorted(d.edges, TIMES, side="right") - 1, d.levels.size - 1)
    return np.array([d.duty(t, p) for t, p in zip(TIMES, pieces, strict=True)])


def assert_close(found: Array, wanted: Array, share: float = CLOSE) -> None:
    """Every column agrees to a share of its range."""
    difference = np.abs(found - wanted).max(axis=0) / np.ptp(wanted, axis=0)
    assert difference.max() < share, difference


@pytest.fixture(scope="module")
def car() -> Model:
    """The quarter car of Table 2.1."""
    return quarter_car()


@pytest.fixture(scope="module", params=DRIVES)
def run(request: pytest.FixtureRequest, car: Model) -> tuple[Drive, Array, Array]:
    """A drive, the truth's states (times, 5) and its outputs a_s, a_us, F_d (times, 3)."""
    d: Drive = request.param

    def rate_of(piece: int) -> Rate:
        return lambda t, x: exact_rates(car, x, d.duty(t, piece), d.road(t, 1))[0]

    states = solved(rate_of, np.zeros(5), d)
    outputs = [exact_rates(car, x, 0.0, 0.0)[1] for x in states]
    return d, states, np.array(outputs)


def test_drives_are_rich(run: tuple[Drive, Array, Array], car: Model) -> None:
    """The gate moves all through its range, the duty from 0 to 1: else agreement would say little."""
    d, states, _ = run
    gate = np.tanh(states @ linearise(car).Gamma)
    assert gate.min() < -0.5
    assert gate.max() > 0.5
    assert duties(d).min() == 0.0
    assert duties(d).max() > 0.6


def test_lipschitz_and_nlpv_forms_move_as_the_truth(
    run: tuple[Drive, Array, Array], car: Model
) -> None:
    """(2.11) and (2.13) in the thesis's state, with the outputs (2.20) and (2.22)."""
    d, states, outputs = run
    form, scheduled = linearise(car), nlpv_form(car)

    def lipschitz(piece: int) -> Rate:
        return lambda t, x: form.rate(x, d.duty(t, piece), d.road(t, 1))

    def nlpv(piece: int) -> Rate:
        return lambda t, x: scheduled.rate(x, d.duty(t, piece), np.array([d.road(t, 1), 0.0, 0.0]))

    for rate_of in (lipschitz, nlpv):
        found = solved(rate_of, np.zeros(5), d)
        assert_close(found, states)
        assert_close(found @ np.vstack([form.C, form.F]).T, outputs)


def test_relative_form_moves_as_the_truth(run: tuple[Drive, Array, Array], car: Model) -> None:
    """Driven by the rate of the truth's tyre deflection, it needs no absolute velocity."""
    d, states, outputs = run
    form, whole = relative_form(car), linearise(car)

    def rate_of(piece: int) -> Rate:
        def rate(t: float, y: Array) -> Array:
            u, road_rate = d.duty(t, piece), d.road(t, 1)
            unknown = y[3] - road_rate  # of the whole car, solved alongside
            return np.concatenate([whole.rate(y[:5], u, road_rate), form.rate(y[5:], u, unknown)])

        return rate

    found = solved(rate_of, np.zeros(9), d)[:, 5:]
    assert_close(found, states @ form.chart.T)
    assert_close(found @ np.vstack([form.C, form.F]).T, outputs)


def test_subsystems_in_a_loop_move_as_the_truth(
    run: tuple[Drive, Array, Array], car: Model
) -> None:
    """(2.8) driven by the road's height, (2.10) by the duty, joined by F_er and the gate."""
    d, states, outputs = run
    suspension, fluid = lti_form(car), qlpv_form(car)

    def rate_of(piece: int) -> Rate:
        def rate(t: float, y: Array) -> Array:
            gate = fluid.gate(np.array([y[0] - y[2], y[1] - y[3]]))
            moved = suspension.rate(y[:4], y[4], d.road(t))
            return np.append(moved, fluid.rate(y[4], d.duty(t, piece), gate))

        return rate

    found = solved(rate_of, np.zeros(5), d)
    roads = np.array([d.road(t) for t in TIMES])
    q = np.column_stack(
        [found[:, 0] - found[:, 2], found[:, 1], found[:, 2] - roads, found[:, 3], found[:, 4]]
    )
    assert_close(q, states)
    y = [suspension.output(x[:4], x[4], r) for x, r in zip(found, roads, strict=True)]
    force = found[:, :4] @ suspension.F + found[:, 4]
    assert_close(np.column_stack([np.array(y)[:, :2], force]), outputs)


def test_descriptor_form_moves_as_the_truth(run: tuple[Drive, Array, Array], car: Model) -> None:
    """(2.19) with a damper that leaks ever more, faster and slower, against (2.18)."""
    d, _, _ = run
    form, healthy = descriptor_form(car), linearise(car)

    def left(t: float) -> float:
        return 1.0 - 0.5 * t / TIMES[-1] * (1.0 - 0.4 * np.sin(40.0 * t))

    def faulty(piece: int) -> Rate:
        """The truth with less force: what a loss takes away acts on both masses."""

        def rate(t: float, x: Array) -> Array:
            slopes, (_, _, force) = exact_rates(car, x, d.duty(t, piece), d.road(t, 1))
            lost = (1.0 - left(t)) * force
            slopes[1] += lost / car.value("quarter_car", "m_s")
            slopes[3] -= lost / car.value("quarter_car", "m_us")
            return slopes

        return rate

    def descriptor(piece: int) -> Rate:
        def rate(t: float, x: Array) -> Array:
            f = lost_force(healthy, x, Factors(leakage=left(t)))
            return form.side(np.append(x, f), d.duty(t, piece), d.road(t, 1))

        return rate

    wanted, found = solved(faulty, np.zeros(5), d), solved(descriptor, np.zeros(5), d)
    assert_close(found, wanted)
    losses = [
        lost_force(healthy, x, Factors(leakage=left(t))) for t, x in zip(TIMES, found, strict=True)
    ]
    assert np.ptp(losses) > 0.05 * np.ptp(found @ healthy.F)


@pytest.mark.parametrize("hertz", [1.5, 4.3, 18.4, 25.0])
def test_passive_response_is_what_a_sine_road_does(car: Model, hertz: float) -> None:
    """Amplitudes of a simulated sine at duty 0, once settled, are those of the frequency response."""
    dt, n = 0.0005, round((1.0 + 4.0 / hertz) / 0.0005)
    t = np.arange(n) * dt
    road = 1e-3 * np.sin(2.0 * np.pi * hertz * t)
    run = simulate(car, dt, road, np.zeros(n))
    wheel = run["tyre_deflection"] + road
    settled = t > t[-1] - 3.0 / hertz
    basis = np.exp(2j * np.pi * hertz * t[settled])
    both = np.column_stack([basis.real, basis.imag])
    response = passive_response(car, np.array([hertz]))[0]
    for signal, wanted in zip((wheel + run["deflection"], wheel, run["deflection"]), response):
        (c, s), *_ = np.linalg.lstsq(both, signal[settled])
        assert abs((s + 1j * c) / 1e-3 - wanted) < 5e-3 * abs(wanted) + 1e-3
