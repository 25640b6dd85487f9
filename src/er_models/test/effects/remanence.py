"""Remanence, worked by hand."""

from worked import YIELD, Force, Rate

WORKED = (
    # magnetised from nothing: 0.3 less 0.05
    Force({"r": 0.05}, YIELD, v=0.1, u=0.3, force=5.0),
    # within the loop the field stays as it is
    Rate({"r": 0.05}, YIELD, w=0.12, v=0.1, u=0.1, rate=0.0, force=2.4),
    # the duty is gone: at once (1e9 per second) down to what is left
    Rate({"r": 0.05}, YIELD, w=0.3, v=0.1, u=0.0, rate=-2.5e8, force=1.0),
)
