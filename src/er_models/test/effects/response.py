"""Response time of the fluid, worked by hand."""

from worked import YIELD, Rate

WORKED = (Rate({"tau": 0.05}, YIELD, w=1.0, v=0.1, u=0.3, rate=100.0, force=1.0),)
