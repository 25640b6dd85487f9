"""Parameters of the observers' nodes. No ROS here."""

from __future__ import annotations

from dataclasses import dataclass

from er_common.common_parameters import (
    FramedParameters,
    awaited_listeners,
    leaving_out,
    oldest_sample,
)
from er_common.parameter_table import REQUIRED, param, tuning


@dataclass(frozen=True, kw_only=True)
class ObserverParameters(FramedParameters):
    """Parameters of the node."""

    model_file: str = tuning(REQUIRED, text="model of the vehicle the gains were made for")
    gains_file: str = tuning(
        REQUIRED,
        text="gains for this model, with a deflection sensor where they were made for one; empty, "
        "while the node is configured: they are made, and the node goes over when they are proved",
    )
    leave_out: bool = leaving_out()
    timeout: float = tuning(
        0.05, unit="s", low=0.005, high=1.0, text="silence after which the estimate is not valid"
    )
    payload: bool = param(
        True, text="whether sprung mass and asymmetry of the damping are estimated and used"
    )
    deflection: bool = param(
        True,
        text="whether the deflection sensor is used where it is there; false: the accelerometers alone",
    )
    max_age: float = oldest_sample()
    listeners: int = awaited_listeners()
