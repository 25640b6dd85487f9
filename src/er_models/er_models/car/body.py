"""The rigid body above four corners: where they are, and what it opposes to their forces.

Axes as in ISO 8855: x forward, y to the left, z up; heave z, roll phi about x, pitch theta about y. The height of
the body above a corner at (x, y) is z + y phi - x theta, so that pitch is positive with the nose down.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from er_models.model import Array, Model

CORNERS = ("front_left", "front_right", "rear_left", "rear_right")
"""Names of the corners, in the order of every array of four."""
MOTIONS = ("heave", "roll", "pitch")
"""Motions of the body, in the order of every array of three."""


@dataclass(frozen=True)
class Car:
    """Body and corners [SI].

    mass: of the body [kg]; roll_inertia, pitch_inertia: about its centre [kg m2]; to_front, to_rear: from the centre
    to the axles [m]; front_track, rear_track: between the wheels [m]; front_bar, rear_bar: anti-roll bars, force at a
    wheel per difference of both deflections [N/m]; height: of the centre above the road [m]; seat: its place (x, y)
    [m]; corners: vehicle models in the order of `CORNERS`. Their own sprung mass is what observers and controllers of
    a corner believe; here the body's counts.
    """

    name: str
    mass: float
    roll_inertia: float
    pitch_inertia: float
    to_front: float
    to_rear: float
    front_track: float
    rear_track: float
    front_bar: float
    rear_bar: float
    height: float
    seat: tuple[float, float]
    corners: tuple[Model, ...]
    source: str = ""

    @cached_property
    def places(self) -> Array:
        """Where the corners are, (4, 2) [m]."""
        front, rear = self.front_track / 2, self.rear_track / 2
        a, b = self.to_front, -self.to_rear
        return np.array([[a, front], [a, -front], [b, rear], [b, -rear]])

    @cached_property
    def shape(self) -> Array:
        """Heights at the corners of unit motions, J (4, 3)."""
        return heights(self.places)

    @cached_property
    def inverse_mass(self) -> Array:
        """Inverse of the body's mass matrix, (3, 3)."""
        return np.diag([1 / self.mass, 1 / self.roll_inertia, 1 / self.pitch_inertia])

    @cached_property
    def compliance(self) -> Array:
        """Acceleration of the body at each corner per force at each, J M^-1 J', (4, 4) [1/kg]."""
        return np.asarray(self.shape @ self.inverse_mass @ self.shape.T)

    @cached_property
    def motions(self) -> Array:
        """Heave, roll and pitch of four heights that lie in one plane, (3, 4)."""
        return np.asarray(np.linalg.pinv(self.shape))

    @property
    def bars(self) -> Array:
        """Stiffness of the anti-roll bar at each corner, (4,) [N/m]."""
        return np.array([self.front_bar] * 2 + [self.rear_bar] * 2)

    def push(self, forward: Array, left: Array) -> Array:
        """Acceleration of the body at the corners while it is driven, (n, 4) [m/s2].

        forward, left: acceleration of the car [m/s2], (n,). Its forces act at the road, `height` below the centre:
        braking (forward below zero) lowers the nose, a turn to the left (left above zero) the right side.
        """
        moments = np.stack([np.zeros_like(left), left, -forward], axis=1) * (
            self.mass * self.height
        )
        return np.asarray(moments @ self.inverse_mass @ self.shape.T)

    def at(self, motions: Mapping[str, Array], place: tuple[float, float]) -> Array:
        """A place's height, velocity or acceleration from those of the body, (n,)."""
        shape = heights(np.array([place]))[0]
        return np.asarray(sum(k * motions[name] for k, name in zip(shape, MOTIONS, strict=True)))


def heights(places: Array) -> Array:
    """Heights at places (n, 2) [m] of unit heave, roll and pitch, (n, 3)."""
    return np.stack([np.ones(len(places)), places[:, 1], -places[:, 0]], axis=1)
