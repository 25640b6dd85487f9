"""From readings of a device to messages, and nothing else."""

from __future__ import annotations

from typing import Any

from er_ros_common.builders import Tick

from er_damper_msgs.msg import PwmDuty, SuspensionDeflection
from er_plant_sim import ros_msgs
from er_plant_sim.hardware.bridge import Reading, Sources
from er_plant_sim.hardware.calibration import Quality, Value
from er_ros_common import builders

SOURCES = Sources(program=int(PwmDuty.SOURCE_PROGRAM), safe=int(PwmDuty.SOURCE_SAFE))
_STATUS = {
    Quality.OK: SuspensionDeflection.STATUS_OK,
    Quality.ABSENT: SuspensionDeflection.STATUS_LOST,
    Quality.UNREAD: SuspensionDeflection.STATUS_LOST,
    Quality.OUT_OF_RANGE: SuspensionDeflection.STATUS_OUT_OF_RANGE,
}


def messages(tick: Tick, r: Reading, *, force_sd: float) -> tuple[Any, ...]:
    """Acceleration, deflection, force, road, applied duty of one reading."""
    sprung, unsprung, deflection, velocity, force, road = r.values
    worst = sprung if sprung.quality is not Quality.OK else unsprung
    moves = velocity.value if velocity.quality is Quality.OK else None
    return (
        builders.suspension_acceleration(tick, sprung.value, unsprung.value, **_said(worst, r)),
        builders.suspension_deflection(tick, deflection.value, moves, **_said(deflection, r)),
        builders.damper_force(tick, force.value, force_sd=force_sd, **_said(force, r)),
        builders.road_displacement(tick, road.value, **_said(road, r)),
        ros_msgs.applied(tick, r.applied),
    )


def lost(tick: Tick) -> tuple[Any, ...]:
    """The same when nothing comes any more; when the device falls back to its own safe duty is not known either."""
    gone: dict[str, Any] = {"status": SuspensionDeflection.STATUS_LOST, "valid": False}
    return (
        builders.suspension_acceleration(tick, 0.0, 0.0, **gone),
        builders.suspension_deflection(tick, 0.0, None, **gone),
        builders.damper_force(tick, 0.0, **gone),
        builders.road_displacement(tick, 0.0, **gone),
        builders.pwm_duty(tick, 0.0, command_seq=0, **gone),
    )


def _said(value: Value, reading: Reading) -> dict[str, Any]:
    """Status and validity of what a device that may be ill reads."""
    status = _STATUS[value.quality]
    if reading.ill and value.quality is Quality.OK:
        status = SuspensionDeflection.STATUS_FAULT
    return {"status": int(status), "valid": status == SuspensionDeflection.STATUS_OK}
