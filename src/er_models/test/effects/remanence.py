"""Remanence, worked by hand."""

from worked import YIELD, Force, Rate

LOOP = {"r": 0.05, "s": 0.4}
WORKED = (
    # magnetised from nothing: 0.3 less 0.4 0.05
    Force(LOOP, YIELD, v=0.1, u=0.3, force=5.6),
    # within the loop the field stays as it is: 0.1 and 0.4 0.02
    Rate(LOOP, YIELD, w=0.12, v=0.1, u=0.1, rate=0.0, force=2.16),
    # the duty is gone: at once (1e9 per second) down to what is left, 0.4 0.05
    Rate(LOOP, YIELD, w=0.3, v=0.1, u=0.0, rate=-2.5e8, force=0.4),
)
