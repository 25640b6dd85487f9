"""Vertical acceleration of a sensor that is mounted somehow: rotation and gravity. No ROS.

Frames follow REP-103: x forward, y left, z up. A sensor is turned by roll, pitch and yaw about the vehicle's x, y and
z, in that order; what it reads along z of the vehicle is the third row of R_z(yaw) R_y(pitch) R_x(roll), where the yaw
has no part. An accelerometer at rest reads the specific force, +g upwards (REP-145).
"""

from __future__ import annotations

import math
from typing import NamedTuple

GRAVITY = 9.80665
"""Standard acceleration of gravity [m/s2], ISO 80000-3."""
UNIT = 0.01
"""How far the length of a quaternion may be from one."""


class Vector(NamedTuple):
    """Three components along the axes of a sensor."""

    x: float
    y: float
    z: float


def upward(roll: float, pitch: float) -> Vector:
    """The vehicle's upward direction in the axes of a sensor that is turned by these angles [rad]."""
    lean = math.cos(pitch)
    return Vector(-math.sin(pitch), lean * math.sin(roll), lean * math.cos(roll))


def upward_of(x: float, y: float, z: float, w: float) -> Vector | None:
    """The world's upward direction in the axes of a sensor with this orientation; None where it is no rotation."""
    if not abs(math.sqrt(x * x + y * y + z * z + w * w) - 1.0) <= UNIT:
        return None
    return Vector(2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y))


def vertical(read: Vector, up: Vector, gravity: float) -> float:
    """Acceleration of the motion upwards [m/s2], of what is read along the axes [m/s2]; gravity: what rest reads."""
    return read.x * up.x + read.y * up.y + read.z * up.z - gravity
