"""Tyre lift-off, worked by hand."""

from worked import Ride

WORKED = (
    # 50 N pull, 2.5 kg half carried by the tyre: 12.2583125 N
    Ride({"r": 0.5}, state=(0.01, 0.3, 0.005, 0.2, 0.05), reported=(-8.0, 7.483375)),
)
SHOWN = {"r": 0.5}
ROAD = 5.0
