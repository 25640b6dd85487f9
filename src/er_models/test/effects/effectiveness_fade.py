"""Fading effectiveness (sedimentation, ageing), worked by hand."""

from worked import YIELD, Rate

WORKED = (
    # no state: 6 N (1 - 0.4 (1 - 1 / e))
    Rate({"s": 0.4, "t_f": 10.0}, YIELD, v=0.1, u=0.3, t=10.0, rate=0.0, force=4.482910658811462),
)
