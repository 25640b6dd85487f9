"""Gain of the velocity channel, worked by hand."""

from worked import PASSIVE, Force

WORKED = (Force({"g_v": 2.0}, PASSIVE, x=0.01, v=0.1, force=3.5),)
