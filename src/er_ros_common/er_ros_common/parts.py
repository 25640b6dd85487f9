"""A message as a part of its tick (`er_common.gather`): its numbers, NaN where they cannot be used."""

from __future__ import annotations

import math
from typing import Any

from er_common.topics import Topic

from er_common import gather, topics
from er_ros_common.stuck import ACCELERATION, DEFLECTION, Watched, check

Sensors = tuple[Watched, Watched]
"""What is known of the accelerometers and of the deflection sensor."""


def part_of(
    topic: Topic, message: Any, stamp: int, sensors: Sensors
) -> tuple[int, gather.Part, Sensors, bool]:
    """Which part of a tick a message is, its values, the sensors after it, and whether one of them is stuck.

    A topic that is none of accelerations, deflection and duty is a force. Of a message that is not valid nothing is
    learnt of its sensor; its values, like those of a stuck one, are NaN.
    """
    body, strut = sensors
    stuck = False
    if topic is topics.ACCELERATION:
        which, part = gather.ACCELERATION, _valid(message, message.sprung, message.unsprung)
        if math.isfinite(part[0]):
            body, stuck = check(body, part, ACCELERATION, stamp)
    elif topic is topics.DEFLECTION:
        velocity = message.velocity if message.velocity_valid else math.nan
        which, part = gather.DEFLECTION, _valid(message, message.deflection, velocity)
        if math.isfinite(part[0]):
            strut, stuck = check(strut, part, DEFLECTION, stamp)
    elif topic is topics.PWM_APPLIED:
        which, part = gather.DUTY, _valid(message, message.duty)
    else:
        which, part = gather.FORCE, _valid(message, message.force)
    return which, (math.nan,) * len(part) if stuck else part, (body, strut), stuck


def _valid(message: Any, *values: float) -> gather.Part:
    return values if message.valid else (math.nan,) * len(values)
