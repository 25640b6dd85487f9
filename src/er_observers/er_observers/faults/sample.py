"""What the fault estimator is told, and what it says."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

from er_common.gather import Tick

_MISSING = ((math.nan, math.nan), (math.nan, math.nan), (math.nan,), (math.nan,))
"""Of a tick: accelerations, deflection and velocity, duty, force."""


class Kind(IntEnum):
    """Which fault it is; SOME: there is one, but the data cannot tell which."""

    SOME = -2
    UNKNOWN = -1
    NONE = 0
    ELECTRICAL = 1
    LEAKAGE = 2
    DEFORMATION = 3
    COMBINED = 4


class FactorStatus(IntEnum):
    """What is known of one factor, in the order of the message."""

    UNKNOWN = 0
    HEALTHY = 1
    SUSPECTED = 2
    CONFIRMED = 3
    NOT_EXCITED = 4
    CONFOUNDED = 5


class Status(IntEnum):
    """Health of the estimator."""

    OK = 0
    INITIALISING = 1
    DEGRADED = 2
    INVALID = 3
    UNEXPLAINED = 4


class Sample(NamedTuple):
    """Accelerations [m/s2], deflection [m] and its velocity [m/s] at t [s], and the duty from then on.

    deflection_velocity: NaN where it is not measured. force [N]: used by an estimator made for one.
    """

    t: float
    sprung_acceleration: float
    unsprung_acceleration: float
    deflection: float
    deflection_velocity: float
    duty: float
    force: float = math.nan


class Estimate(NamedTuple):
    """What is left of the damper: f1, f2, f3 with deviations and statuses, and which fault it is how certainly.

    residual [N]: rms of the force beyond noise that neither faults nor tolerance explain; test_ratio: above 1 that is
    more than can be; unexplained: it has been for a while. INVALID estimates hold ones and no certainty.
    """

    factors: tuple[float, float, float]
    deviations: tuple[float, float, float]
    states: tuple[FactorStatus, FactorStatus, FactorStatus]
    kind: Kind
    certainty: float
    residual: float
    test_ratio: float
    unexplained: bool
    status: Status
    reason: str


NOTHING = Estimate(
    (1.0,) * 3, (0.0,) * 3, (FactorStatus.UNKNOWN,) * 3, Kind.UNKNOWN, 0.0, 0.0, 0.0, False,
    Status.INITIALISING, "no sample yet",
)  # type: ignore[arg-type]  # fmt: skip


def sample_of(tick: Tick, base: int) -> Sample:
    """The sample of a tick, its time from the stamp `base` on; NaN for what is missing."""
    each = zip(tick.parts, _MISSING, strict=True)
    (body, wheel), (x, v), (u,), (f,) = [
        missing if part is None else part for part, missing in each
    ]
    return Sample(1e-9 * (tick.stamp - base), body, wheel, x, v, u, f)
