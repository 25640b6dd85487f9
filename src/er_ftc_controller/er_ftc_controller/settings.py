"""Parameters of the fault-tolerant controller, and the controller they describe. No ROS here."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from er_common.common_parameters import (
    FramedParameters,
    awaited_listeners,
    oldest_sample,
    sample_rate,
)
from er_common.parameter_table import REQUIRED, param, tuning
from er_models.constants import SAMPLE_RATE
from er_models.errors import InputError
from er_models.model import Model
from er_models.static_damper import static_damper

from er_ftc_controller import lpv
from er_ftc_controller.control import Ftc, Rules
from er_ftc_controller.force_loop import ForceLoop
from er_ftc_controller.gains import Loaded
from er_ftc_controller.state_law import StateLaw
from er_ftc_controller.synthesis.solution import NoController
from er_ftc_controller.synthesis.state_proof import falls, loops_of

LAWS = ("fault_tolerant", "nominal")
FEEDBACKS = ("state", "deflection")


@dataclass(frozen=True, kw_only=True)
class FtcParameters(FramedParameters):
    """Parameters of the node."""

    model_file: str = param(REQUIRED, text="model of the vehicle the gains were made for")
    gains_file: str = param(REQUIRED, text="gains of the LPV controller for this model")
    law: str = param(
        "fault_tolerant",
        choices=LAWS,
        text="fault_tolerant: the forces asked for follow the faults; nominal: as if the damper were healthy",
    )
    feedback: str = param(
        "state",
        choices=FEEDBACKS,
        text="state: scheduled state feedback while accelerations come; deflection: the LPV law of the thesis alone",
    )
    rate: float = sample_rate()
    u_min: float = tuning(REQUIRED, low=0.0, high=1.0, text="least duty")
    u_max: float = tuning(REQUIRED, low=0.0, high=1.0, text="greatest duty")
    safe_duty: float = tuning(REQUIRED, low=0.0, high=1.0, text="duty without usable samples")
    mu: float = tuning(
        REQUIRED,
        unit="N",
        low=1e-6,
        high=1e6,
        text="distance to the forces the damper can give from which on rho (6.16) rises",
    )
    largest_deflection: float = tuning(
        REQUIRED, unit="m", low=1e-6, high=10.0, text="largest deflection that is believed"
    )
    largest_velocity: float = tuning(
        REQUIRED,
        unit="m/s",
        low=1e-6,
        high=1e3,
        text="largest deflection velocity that is believed",
    )
    horizon: float = tuning(
        0.01,
        unit="s",
        low=0.0,
        high=10.0,
        text="time in which the force loop reaches its force; 0: inverse static model",
    )
    correction: float = tuning(
        0.0,
        low=0.0,
        high=1.0,
        text="share of the difference to the accelerometer's force that is corrected per sample",
    )
    latency: float = tuning(
        0.0,
        unit="s",
        low=0.0,
        high=0.1,
        text="time from a sample until the duty that answers it acts",
    )
    ahead: float = tuning(
        0.0025,
        unit="s",
        low=0.0,
        high=0.1,
        text="time from the moment a duty begins to act to the middle of the time it acts: half a sample",
    )
    slew: float = tuning(
        0.0, unit="1/s", low=0.0, high=1e4, text="fastest change of the duty; 0: any"
    )
    dead_zone: float = tuning(0.0, low=0.0, high=0.5, text="duties below it become u_min")
    least_gate: float = tuning(
        0.4,
        low=0.0,
        high=0.9,
        text="least |s|, the gate of the yield force (2.10), that a duty is computed with",
    )
    restore: float = tuning(
        0.0, low=0.0, high=1.0, text="share of the lost passive force that the field gives back"
    )
    timeout: float = tuning(
        0.025,
        unit="s",
        low=0.005,
        high=1.0,
        text="silence of the inputs after which it goes to the safe duty",
    )
    ramp: float = tuning(
        0.02,
        unit="s",
        low=0.001,
        high=1.0,
        text="time to fade from the controlled duty to the safe one",
    )
    recovery: float = tuning(
        0.1,
        unit="s",
        low=0.001,
        high=10.0,
        text="time to fade back from the safe duty to the controlled one",
    )
    fade: float = tuning(
        2.0,
        unit="1/s",
        low=0.01,
        high=100.0,
        text="fastest change of the fault factors that the controller uses",
    )
    fault_age: float = tuning(
        0.5, unit="s", low=0.01, high=60.0, text="age after which a fault estimate counts as old"
    )
    least_left: float = tuning(
        0.05,
        low=0.0,
        high=0.9,
        text="share of the field's force left by faults below which it goes to the safe duty",
    )
    max_age: float = oldest_sample()
    listeners: int = awaited_listeners()


def controller_of(p: FtcParameters, model: Model, loaded: Loaded) -> Ftc:
    """The controller; raises `InputError` where values contradict, no static law is there, or no proof for the rate."""
    damper, duties = static_damper(model), (p.u_min, p.u_max)
    if not p.u_min <= p.u_max:
        raise InputError("ftc_controller", "u_min, u_max", "u_min <= u_max", duties)
    tau = model.value("response", "tau") if "response" in model.effects else 0.0
    loop = ForceLoop(
        damper, tau, duties, p.horizon or math.inf, p.correction,
        p.slew or math.inf, p.dead_zone, p.least_gate,
    )  # fmt: skip
    rules = Rules(
        p.safe_duty, (p.largest_deflection, p.largest_velocity), p.timeout, p.ramp, p.recovery,
        gap=max(Rules.gap, 2.0 * p.timeout), fade=p.fade, fault_age=p.fault_age, least_left=p.least_left,
        restore=p.restore, latency=p.latency, ahead=p.ahead, adapt=p.law == "fault_tolerant",
    )  # fmt: skip
    car = model.effects["quarter_car"]
    body = (car["m_s"], car["k_s"])
    law = lpv.controller(loaded, damper, duties, p.mu, p.rate)
    return Ftc(law, loop, rules, body, _feedback(p, model, loaded))


def _feedback(p: FtcParameters, model: Model, loaded: Loaded) -> StateLaw | None:
    """The state feedback, if it is asked for, the gains hold one, and it is proved for the rate; else none."""
    if p.feedback == "deflection" or loaded.feedback is None:
        return None
    law, proof = loaded.feedback
    loops, sample = loops_of(model, [np.array(k) for k in law.gains], law.corner), 1.0 / p.rate
    if p.rate != SAMPLE_RATE and not falls(loops, proof.P_sampled, sample):
        from er_ftc_controller.synthesis.state_solve import common

        try:
            return law if falls(loops, common(loops, sample), sample) else None
        except NoController:
            return None
    return law
