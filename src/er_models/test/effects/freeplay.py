"""Freeplay (backlash), worked by hand."""

from worked import CUBE, PASSIVE, Force, Rate

RIGID, ELASTIC = {"b": 0.002, "q": 0.0}, {"b": 0.002, "q": 1e-3}
WORKED = (
    Force(RIGID, PASSIVE, x=0.01, v=0.1, force=5.8),
    # a spring of 1000 N/m and one of 100 N/m share the 8 mm that are left of the stroke, and 5 N
    Force(ELASTIC, PASSIVE, x=0.01, v=0.1, force=5.8 / 1.1),
    # open, free of force: 100 N/m 9 mm and 1e6 (9 mm)^3 push the damper 50 Ns/m -0.03258 m/s
    Rate(RIGID, {**PASSIVE, **CUBE}, w=0.001, x=0.01, v=0.1, rate=0.13258, force=0.0),
    # closed by 1 mm: 1 N in the joint, of which 100 N/m 7 mm leave 0.3 N for 50 Ns/m
    Rate(ELASTIC, PASSIVE, w=0.003, x=0.01, v=0.1, rate=0.094, force=1.0),
)
SHOWN = {"b": 0.0006, "q": 2e-5}
