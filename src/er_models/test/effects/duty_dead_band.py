"""Dead band of the duty, worked by hand."""

from worked import YIELD, Force

WORKED = (Force({"u_0": 0.1}, YIELD, v=0.1, u=0.3, force=4.0),)
