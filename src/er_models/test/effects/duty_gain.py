"""Gain of the high-voltage chain, worked by hand."""

from worked import YIELD, Force

WORKED = (Force({"g_u": 0.5}, YIELD, v=0.1, u=0.3, force=3.0),)
