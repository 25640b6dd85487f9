"""Quadratic (orifice) damping, worked by hand."""

from worked import Force

WORKED = (Force({"c_2": 200.0}, v=-0.1, force=-2.0),)
