"""Lag of the velocity channel, worked by hand."""

from worked import PASSIVE, Force

WORKED = (Force({"T_v": 0.01}, PASSIVE, v=0.1, a=5.0, force=7.5),)
