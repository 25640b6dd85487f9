"""What the observer says of its own estimate, with a reason, switched with hysteresis."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple


class Status(IntEnum):
    """Health of an estimate."""

    OK = 0
    INITIALISING = 1
    DEGRADED = 2
    INVALID = 3
    WEAK = 4


@dataclass(frozen=True, slots=True)
class Limits:
    """When a status changes.

    hold: time without valid sample until the estimate is invalid and the next one starts afresh
    [s]. bridge: until it is degraded [s]. recover: degraded for so long after a repair [s].
    window: length of all averages [s]. settled: share of the first error that may be left. weak,
    strong: rates at which an error of the deflection decays, below which observability is called
    weak and above which good again [1/s]. acceleration: largest believable magnitudes, sprung and
    unsprung [m/s2]. deflection: largest believable one [m]. noise: accelerometer noise that
    contradicts nothing [m/s2]. clear: test ratio below which a contradiction is over.
    """

    hold: float = 0.05
    bridge: float = 0.02
    recover: float = 0.1
    window: float = 0.25
    settled: float = 0.05
    weak: float = 2.0
    strong: float = 4.0
    acceleration: tuple[float, float] = (200.0, 2000.0)
    deflection: float = 1.0
    noise: float = 0.05
    clear: float = 0.7


ROUNDING = 1e-9
"""Times that are closer are equal: stamps are sums of rounded periods [s]."""

LIMITS = Limits()
"""Limits of a car of the size of the thesis's rig up to a real one."""


class Health(NamedTuple):
    """Memory of the watch, as `watch` keeps it in an array (8,) in this order.

    doubt: share of the first error that may be left, 1 at the start; decay: average rate at which
    an error decays [1/s]; lost: time since the last valid sample [s]; healing: time until a repair
    is forgotten [s]; power and floor: averages of the squared correction and of what noise and
    sampling explain of it [m2/s2]; weak, contradicted: switches.
    """

    doubt: float
    decay: float
    lost: float
    healing: float
    power: float
    floor: float
    weak: bool
    contradicted: bool


FINE, UNSETTLED, REPAIRED, GONE, BLIND, CONFLICTING, UNTOLD, ALONE, WRONG = range(9)
VERDICTS = {
    FINE: (Status.OK, ""),
    UNSETTLED: (Status.INITIALISING, "the first error has not decayed yet"),
    REPAIRED: (Status.DEGRADED, "samples or duties were repaired"),
    GONE: (Status.INVALID, "no valid sample for too long"),
    BLIND: (Status.WEAK, "the fluid hardly yields: accelerometers do not see the deflection"),
    CONFLICTING: (Status.DEGRADED, "the accelerations contradict the damper model"),
    UNTOLD: (Status.DEGRADED, "a load or a loss of the damper: not told apart"),
    ALONE: (Status.DEGRADED, "the deflection sensor is refused: from the accelerometers alone"),
    WRONG: (Status.DEGRADED, "the accelerations contradict the deflection sensor"),
}
"""What `watch.judge` and `payload` may say: a status and its reason."""
