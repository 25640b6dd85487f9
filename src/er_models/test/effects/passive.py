"""Passive stiffness and viscosity, worked by hand."""

from worked import Force

WORKED = (Force({"k0": 100.0, "c0": 50.0}, x=0.01, v=0.1, force=6.0),)
