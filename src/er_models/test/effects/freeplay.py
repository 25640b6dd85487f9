"""Freeplay (backlash), worked by hand."""

from worked import CUBE, PASSIVE, Force, Rate

WORKED = (
    Force({"b": 0.002}, PASSIVE, x=0.01, v=0.1, force=5.8),
    # open, free of force: 100 N/m 9 mm and 1e6 (9 mm)^3 push the damper 50 Ns/m -0.03258 m/s
    Rate({"b": 0.002}, {**PASSIVE, **CUBE}, w=0.001, x=0.01, v=0.1, rate=0.13258, force=0.0),
)
SHOWN = {"b": 0.0006}
