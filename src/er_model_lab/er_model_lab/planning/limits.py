"""What a program may ask of the rig, and how noisy its sensors are."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from er_models.constants import SAMPLE_TIME
from er_models.errors import InputError
from er_models.model import Model

from er_model_lab.problem.problem import Problem

ROAD_PER_STROKE = 3.0
"""Height of the road over the stroke where the rig says nothing of its actuator under the wheel."""
SHORTEST, LONGEST = 10.0, 600.0
"""Length of a program [s]."""


@dataclass(frozen=True)
class Limits:
    """Largest |deflection| [m], |deflection velocity| [m/s], duty and |road| [m]; length and sample time [s]."""

    stroke: float
    velocity: float
    duty: float
    road: float
    duration: float = 30.0
    dt: float = SAMPLE_TIME

    def raised(self, name: str, factor: float) -> Limits:
        """The same with one limit raised; the duty never above 1, the road along with the stroke."""
        value = getattr(self, name) * factor
        if name == "stroke":
            return replace(self, stroke=value, road=self.road * factor)
        return replace(self, **{name: min(value, 1.0) if name == "duty" else value})


@dataclass(frozen=True)
class Sensors:
    """White noise of the rig's sensors: deflection [m], velocity [m/s], accelerations [m/s2], force [N]."""

    deflection: float
    velocity: float
    acceleration: float
    force: float


@dataclass(frozen=True)
class Asked:
    """Limits a user gave; None: the model's `rig` section says."""

    stroke: float | None = None
    velocity: float | None = None
    duty: float | None = None
    duration: float | None = None


def nothing_fits(limits: Limits) -> InputError:
    """What is said where no motion of the menu can be run."""
    expected = (
        "limits (stroke, velocity, duration) within which some motion of the menu can be run"
    )
    found = f"{1e3 * limits.stroke:.3g} mm, {limits.velocity:.3g} m/s, {limits.duration:g} s"
    return InputError("plan", "limits", expected, found)


def limits_of(model: Model, asked: Asked, dt: float) -> Limits:
    """Limits of a model's rig, or of its envelope where the rig says nothing, and what was asked.

    Raises `InputError` naming the argument: not above 0, a duty above 1, too short or too long.
    """
    rig, scales = model.rig, model.scales
    stroke = _positive("stroke", "m", asked.stroke, rig.get("stroke", scales.deflection))
    duty = _positive("duty_max", "1", asked.duty, rig.get("duty_max", min(scales.duty, 1.0)))
    if duty > 1.0:
        raise InputError("duty_max", "", "a duty of at most 1", f"{duty:g}")
    duration = _positive("duration", "s", asked.duration, Limits.duration)
    if not SHORTEST <= duration <= LONGEST:
        raise InputError("duration", "", f"{SHORTEST:g} to {LONGEST:g} s", f"{duration:g}")
    velocity = rig.get("velocity_max", scales.velocity)
    return Limits(
        stroke,
        _positive("velocity", "m/s", asked.velocity, velocity),
        duty,
        rig.get("road", ROAD_PER_STROKE * stroke),
        duration,
        dt,
    )


def _positive(name: str, unit: str, asked: float | None, known: float) -> float:
    """What was asked, or what is known; `InputError` when it is not above 0."""
    value = known if asked is None else asked
    if not (math.isfinite(value) and value > 0.0):
        raise InputError(name, "", f"a number above 0 in {unit}", f"{value:g}")
    return float(value)


def sensors_of(model: Model, problem: Problem | None) -> tuple[Sensors, str]:
    """Noise of the sensors and where it is known from: data, the model's rig, or a share of its envelope."""
    if problem is not None:
        n = problem.noise
        return Sensors(n.x, n.v, n.a, problem.sd_force), "the data"
    s = model.scales
    assumed = {
        "deflection_noise": 2e-3 * s.deflection,
        "velocity_noise": 7e-3 * s.velocity,
        "acceleration_noise": 1e-2 * s.acceleration,
        "force_noise": 7e-3 * s.force,
    }
    known = [name for name in assumed if name in model.rig]
    values = [model.rig.get(name, value) for name, value in assumed.items()]
    if len(known) == len(assumed):
        return Sensors(*values), "the model's rig"
    return Sensors(*values), "assumed: shares of the model's envelope"
