"""Inertia of fluid and piston, worked by hand."""

from worked import Force

WORKED = (Force({"m_f": 0.2}, a=-5.0, force=-1.0),)
