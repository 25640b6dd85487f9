"""Damping of the tyre, worked by hand."""

from worked import Ride

WORKED = (
    # 20 N s/m 0.15 m/s = 3 N
    Ride({"c_t": 20.0}, reported=(-8.0, 6.0)),
)
