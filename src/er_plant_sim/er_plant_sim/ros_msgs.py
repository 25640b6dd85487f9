"""From the rig's measurement and duty to messages, and nothing else."""

from __future__ import annotations

from er_ros_common.builders import Tick

from er_damper_msgs.msg import (
    DamperForce,
    PwmDuty,
    RoadDisplacement,
    SuspensionAcceleration,
    SuspensionDeflection,
)
from er_plant_sim.duty_gate import Applied, Reason
from er_plant_sim.simulator import Measurement
from er_ros_common import builders

_STATUS = {
    Reason.COMMAND: PwmDuty.STATUS_OK,
    Reason.PROGRAM: PwmDuty.STATUS_OK,
    Reason.NO_COMMAND: PwmDuty.STATUS_INITIALIZING,
    Reason.OLD_COMMAND: PwmDuty.STATUS_LOST,
    Reason.CONFLICT: PwmDuty.STATUS_FAULT,
}


def acceleration(tick: Tick, m: Measurement) -> SuspensionAcceleration:
    """Both accelerations."""
    return builders.suspension_acceleration(tick, m.sprung_acceleration, m.unsprung_acceleration)


def deflection(tick: Tick, m: Measurement) -> SuspensionDeflection:
    """Deflection and its velocity."""
    return builders.suspension_deflection(tick, m.deflection, m.deflection_velocity)


def force(tick: Tick, m: Measurement, deviation: float) -> DamperForce:
    """Measured damper force; deviation: standard deviation of its noise [N]."""
    return builders.damper_force(tick, m.force, force_sd=deviation)


def road(tick: Tick, m: Measurement) -> RoadDisplacement:
    """Height of the road."""
    return builders.road_displacement(tick, m.road)


def applied(tick: Tick, duty: Applied) -> PwmDuty:
    """The duty after all limits, with the command it came from."""
    return builders.pwm_duty(
        tick,
        duty.duty,
        command_seq=duty.command_seq,
        source=_source(duty),
        saturated=duty.saturated,
        status=_STATUS[duty.reason],
    )


def _source(duty: Applied) -> int:
    if duty.reason is Reason.PROGRAM:
        return int(PwmDuty.SOURCE_PROGRAM)
    if duty.reason is not Reason.COMMAND:
        return int(PwmDuty.SOURCE_SAFE)
    return duty.source if duty.source <= PwmDuty.SOURCE_SAFE else int(PwmDuty.SOURCE_UNKNOWN)
