"""Coulomb friction, worked by hand."""

from worked import Force

WORKED = (
    # -2 tanh 1
    Force({"F_c": 2.0, "v_0": 0.02, "r": 0.0}, v=-0.02, force=-1.5231883119115297),
    # half of it slow: -(tanh 1 + 2 / pi atan 1)
    Force({"F_c": 2.0, "v_0": 0.02, "r": 0.5}, v=-0.02, force=-1.2615941559557649),
)
