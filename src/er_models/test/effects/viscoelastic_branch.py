"""Viscoelastic branch (Maxwell), worked by hand."""

from worked import Force, Rate

WORKED = (
    Force({"k_m": 100.0, "t_m": 0.05}, v=0.2, force=1.0),
    Rate({"k_m": 100.0, "t_m": 0.05}, w=0.4, v=0.2, rate=12.0, force=0.4),
)
