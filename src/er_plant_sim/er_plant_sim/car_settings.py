"""Parameters of the plant of a whole car. No ROS here."""

from __future__ import annotations

from dataclasses import dataclass

from er_common.parameter_table import REQUIRED, param

from er_plant_sim.rig_parameters import RunParameters
from er_plant_sim.settings import SensorErrors


@dataclass(frozen=True, kw_only=True)
class CarParameters(RunParameters, SensorErrors):
    """Every parameter of the car's plant."""

    car_file: str = param(
        REQUIRED,
        text="the car: body and four corners; limits of the duty are those of the corners' models",
    )
    speed: float = param(
        5.0,
        unit="m/s",
        low=0.1,
        high=100.0,
        text="of the car: how late the rear wheels meet the road",
    )
    coherence: float = param(
        0.7, low=-1.0, high=1.0, text="how much both tracks of a random road share; 1: no roll"
    )
    mode: str = param(
        "realtime",
        choices=("realtime", "sim_time"),
        text="pace: of the real clock or of simulated time",
    )
    rate_factor: float = param(1.0, low=0.01, high=50.0, text="speed of simulated time")
    load_timeout: float = param(
        0.2,
        unit="s",
        low=0.01,
        high=10.0,
        text="age at which braking and cornering loads are forgotten",
    )
