"""Parameters of the monitor's node. No ROS here."""

from __future__ import annotations

from dataclasses import dataclass

from er_common.common_parameters import (
    FramedParameters,
    awaited_listeners,
    oldest_sample,
    sample_rate,
)
from er_common.parameter_table import REQUIRED, param
from er_common.topics import FORCE

from er_model_lab.monitor.sequential import HOUR, RULES


@dataclass(frozen=True, kw_only=True)
class MonitorParameters(FramedParameters):
    """Parameters of the node."""

    model_file: str = param(REQUIRED, text="model of the damper, or of the car with it")
    rate: float = sample_rate()
    force_source: str = param(
        FORCE.name,
        text="topic of the force to compare with: measured, or an observer's, as force/unified",
    )
    learn: float = param(
        RULES.blocks * RULES.block,
        unit="s",
        low=10.0,
        high=HOUR,
        text="motion from which is learnt how large the error is where the model explains",
    )
    floor: float = param(
        0.0,
        unit="N",
        low=0.0,
        high=1e6,
        text="error of the model where it explains; 0: as large as it is at first",
    )
    change: float = param(
        RULES.change,
        low=0.1,
        high=3.0,
        text="growth of the error that is to be found, as a share of it",
    )
    between: float = param(
        RULES.between,
        unit="s",
        low=HOUR,
        high=1e4 * HOUR,
        text="motion between two false alarms, in the mean",
    )
    memory: float = param(
        300.0,
        unit="s",
        low=10.0,
        high=HOUR,
        text="how much of what was heard last ~/diagnose can learn from",
    )
    models: str = param("models", text="folder for the models that ~/diagnose makes")
    along: tuple[str, ...] = param(
        (), text="nodes that ~/use_model asks to go over to the model, too: a plant, observers"
    )
    timeout: float = param(
        0.05,
        unit="s",
        low=0.005,
        high=1.0,
        text="silence after which the force is not valid, or the damper begins anew",
    )
    max_age: float = oldest_sample()
    listeners: int = awaited_listeners()
