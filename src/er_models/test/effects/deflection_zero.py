"""Zero of the deflection sensor, worked by hand."""

from worked import PASSIVE, Force

WORKED = (Force({"x_0": 0.002}, PASSIVE, x=0.01, force=1.2),)
