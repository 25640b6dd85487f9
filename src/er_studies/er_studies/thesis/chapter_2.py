"""Chapter 2 of the thesis: the quarter car in all its forms, their frequency responses, what sensors tell of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.files import load_model
from er_models.forms import ride
from er_models.forms.lipschitz import linearise
from er_models.forms.loss import Factors, damaged
from er_models.forms.lti import lti_form
from er_models.forms.passive import passive_peaks, passive_response
from er_models.forms.qlpv import qlpv_form
from er_models.forms.response import Peak, frequency_response
from er_models.forms.sensing import Sensing, sensings
from er_models.forms.zeros import visibility
from er_models.model import Array, Model
from er_models.program import load_program, resolve, times
from er_models.simulation import simulate

FINE = 40
"""Parts a sample is cut into for the record that the forms are compared with: its error is far below theirs."""
HERTZ = np.geomspace(0.2, 60.0, 600)
SLOW = np.geomspace(1e-3, 60.0, 200)
DUTIES = (0.0, 0.1, 0.3, 1.0)
"""Held duties of the pictures; 0.3 is the limit of the testbench, 1 that of Table 2.2."""
GATES = (1.0, 0.5, 0.1)
LEAK = Factors(leakage=0.6)
"""The fault of section 6.4: f_2 = 60 %."""
FORMS: dict[str, ride.Ride] = {
    "LTI (2.8) with qLPV (2.10)": ride.subsystems,
    "Lipschitz (2.11)": ride.lipschitz,
    "NLPV (2.13)": ride.nlpv,
    "relative": ride.relative,
}
PUBLISHED = {"z_s": (4.0,), "z_us": (4.0, 20.0), "z_def": ()}
"""Peaks read by the thesis from figures 6.13 to 6.15 [Hz], "at 4 Hz" and "around 20 Hz"; none named for z_def."""


@dataclass(frozen=True, eq=False)
class Bode:
    """Gains over `HERTZ`, (k,) each.

    passive (k, 3): z_s, z_us, z_def over z_r; suspension (k, 3): both accelerations and the
    deflection over u_er; fluid: F_er over the duty, by gate; force: F_d over the rate of the road for
    small motions, by duty.
    """

    passive: Array
    suspension: Array
    fluid: dict[float, Array]
    force: dict[float, Array]


@dataclass(frozen=True, eq=False)
class Ride:
    """Signals (n, 4) of `er_models.forms.ride.SIGNALS` on one road: the record's and each form's.

    leaking: the record of a leaking damper; descriptor: (2.19) with the same leak; lost (n,): its f [N].
    """

    t: Array
    road: Array
    duty: Array
    record: Array
    forms: dict[str, Array]
    leaking: Array
    descriptor: Array
    lost: Array


@dataclass(frozen=True, eq=False)
class Chapter2:
    """Everything that is shown of a vehicle model; visible: by system, over `SLOW`."""

    model: Model
    bode: Bode
    peaks: dict[str, list[Peak]]
    systems: tuple[Sensing, ...]
    visible: tuple[Array, ...]
    ride: Ride


def chapter_2(config: Path, tick: Callable[[str], None] | None = None) -> Chapter2:
    """Make all of it.

    config: folder with `vehicles/inove_quarter_car.yaml` and `simulations/chapter_2.yaml`. Raises
    `InputError` for files that are not there or not good, `NotThisForm` for a car the forms cannot hold.
    """
    say = tick or (lambda _: None)
    model = load_model(config / "vehicles" / "inove_quarter_car.yaml")
    program = resolve(load_program(config / "simulations" / "chapter_2.yaml"), model, DT)
    say("frequency responses")
    systems = sensings(model)
    visible = tuple(visibility(s.A, s.D, s.C, s.H, SLOW) for s in systems)
    t = times(program.duration, DT)
    ridden = ridden_by_all(model, t, *program.signals(t), say)
    return Chapter2(model, bode(model), passive_peaks(model, HERTZ), systems, visible, ridden)


def bode(model: Model) -> Bode:
    """Gains of the forms of a vehicle model."""
    suspension, fluid, whole = lti_form(model), qlpv_form(model), linearise(model)
    by_force = frequency_response(
        suspension.A, suspension.B[:, None], suspension.C, HERTZ, suspension.C_u[:, None]
    )
    lag = np.abs(frequency_response(np.array([[fluid.A]]), np.eye(1), np.eye(1), HERTZ)[:, 0, 0])
    force = {
        u: np.abs(
            frequency_response(whole.frozen(u, 1.0), whole.D1[:, None], whole.F[None], HERTZ)
        )[:, 0, 0]
        for u in DUTIES
    }
    return Bode(
        np.abs(passive_response(model, HERTZ)),
        np.abs(by_force[:, :, 0]),
        {gate: lag * fluid.B * gate for gate in GATES},
        force,
    )


def ridden_by_all(
    model: Model, t: Array, road: Array, duty: Array, say: Callable[[str], None]
) -> Ride:
    """One road (n,) [m] and duty (n,) for the record and for every form."""
    forms = {}
    for name, form in FORMS.items():
        say(f"riding, {name}")
        forms[name] = form(model, DT, road, duty)
    say("riding, descriptor (2.19)")
    descriptor, lost = ride.descriptor(model, DT, road, duty, LEAK)
    record, leaking = (recorded(m, road, duty) for m in (model, damaged(model, LEAK)))
    return Ride(t, road, duty, record, forms, leaking, descriptor, lost)


def recorded(model: Model, road: Array, duty: Array) -> Array:
    """Signals (n, 4) of the compiled model, in steps short enough for its error not to show."""
    n = road.size
    fine = np.arange(FINE * (n - 1) + 1) / FINE
    heights = np.interp(fine, np.arange(n), road)
    record = simulate(model, DT / FINE, heights, duty[fine.astype(int)])
    return np.column_stack([record[name][::FINE] for name in ride.SIGNALS])


def departures(found: Array, wanted: Array) -> Array:
    """Largest difference of each signal as a share of its range, (4,)."""
    return np.asarray(np.abs(found - wanted).max(axis=0) / np.ptp(wanted, axis=0))
