"""Rebound-compression asymmetry, worked by hand."""

from worked import Force

WORKED = (Force({"c_a": 10.0}, v=-0.2, force=2.0),)
