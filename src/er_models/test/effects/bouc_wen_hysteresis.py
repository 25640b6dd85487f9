"""Pre-sliding hysteresis (Dahl, Bouc-Wen), worked by hand."""

from worked import Force, Rate

WORKED = (
    Force({"F_h": 2.0, "F_u": 10.0, "z_y": 1e-3}, v=-0.1, u=0.3, force=-5.0),
    Rate({"F_h": 2.0, "F_u": 10.0, "z_y": 1e-3}, w=-5e-4, v=-0.1, u=0.3, rate=-0.05, force=-2.5),
)
