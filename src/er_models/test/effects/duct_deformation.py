"""Deformation of the duct (f3), worked by hand: it takes all of a part, or nothing."""

from worked import fault

WORKED = fault(stiffness=0.0, viscosity=1.0, field=1.0)
