"""Gain of the force channel, worked by hand."""

from worked import PASSIVE, Force

WORKED = (Force({"g_F": 1.5}, PASSIVE, x=0.01, v=0.1, force=9.0),)
