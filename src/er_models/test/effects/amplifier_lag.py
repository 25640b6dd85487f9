"""Lag of the amplifier, worked by hand."""

from worked import YIELD, Rate

WORKED = (Rate({"T_a": 0.02}, YIELD, w=0.1, v=0.1, u=0.3, rate=10.0, force=2.0),)
