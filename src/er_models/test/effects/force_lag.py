"""Lag of the force sensor, worked by hand."""

from worked import PASSIVE, Force, Rate

WORKED = (
    Force({"T_f": 0.01}, PASSIVE, x=0.01, v=0.1, force=6.0),
    Rate({"T_f": 0.01}, PASSIVE, w=2.0, v=0.1, rate=300.0, force=5.0),
)
