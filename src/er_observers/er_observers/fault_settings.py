"""Parameters of the fault estimator's node. No ROS here."""

from __future__ import annotations

from dataclasses import dataclass

from er_common.common_parameters import (
    FramedParameters,
    awaited_listeners,
    leaving_out,
    oldest_sample,
    sample_rate,
)
from er_common.parameter_table import REQUIRED, param, tuning
from er_common.topics import estimated_force

from er_observers.programs import OBSERVERS

NONE, MEASURED = "none", "measured"
SOURCES = (NONE, MEASURED, *(estimated_force(name).name for name in OBSERVERS))


@dataclass(frozen=True, kw_only=True)
class FaultParameters(FramedParameters):
    """Parameters of the node."""

    model_file: str = tuning(REQUIRED, text="model of the healthy vehicle")
    leave_out: bool = leaving_out()
    rate: float = sample_rate()
    force_source: str = param(
        NONE,
        choices=SOURCES,
        text="where the damper force comes from; none: from the sprung mass and its acceleration",
    )
    force_noise: float = param(
        0.0,
        unit="N",
        low=0.0,
        high=1e5,
        text="standard deviation of that force; 0: that of the model file's rig",
    )
    tolerance: float = param(
        0.05,
        low=0.001,
        high=0.5,
        text="relative standard deviation of the model's parameters from the car's",
    )
    smallest_loss: float = param(
        0.06, low=0.01, high=0.5, text="smallest loss of force that is called a fault"
    )
    timeout: float = tuning(
        0.05, unit="s", low=0.005, high=1.0, text="silence after which the estimate is not valid"
    )
    max_age: float = oldest_sample()
    listeners: int = awaited_listeners()
