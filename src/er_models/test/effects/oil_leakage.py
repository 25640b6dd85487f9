"""Oil leakage (f2), worked by hand: it takes all of a part, or nothing."""

from worked import fault

WORKED = fault(stiffness=1.0, viscosity=1.0, field=1.0)
