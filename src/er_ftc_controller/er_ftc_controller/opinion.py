"""What the controller makes of a fault estimate's statuses: act on it, forget the faults, or stay as it is."""

from __future__ import annotations

from collections.abc import Sequence

from er_ftc_controller.control import Faults

UNKNOWN, HEALTHY, SUSPECTED, CONFIRMED, NOT_EXCITED, CONFOUNDED = range(6)
"""Status of a factor, in the order of the message."""
SMALL = 0.06
"""Loss up to which a factor that is not excited counts as none."""


def opinion(t: float, factors: Sequence[float], states: Sequence[int], *, trusted: bool) -> Faults:
    """Faults at t [s] for factors f1, f2, f3 and their statuses.

    A confirmed loss, or one that is there but cannot be told from another, is certain. What is suspected, or was lost
    when it was last excited, is neither certain nor healthy: such an estimate may not be used.
    """
    certain = CONFIRMED in states or CONFOUNDED in states
    well = all(
        s == HEALTHY or (s == NOT_EXCITED and f >= 1.0 - SMALL)
        for s, f in zip(states, factors, strict=True)
    )
    usable = trusted and UNKNOWN not in states and (certain or well)
    f1, f2, f3 = factors
    return Faults(t, f1, f2, f3, certain=certain, usable=usable)
