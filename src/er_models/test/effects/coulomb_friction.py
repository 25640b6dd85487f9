"""Coulomb friction, worked by hand."""

from worked import Force

WORKED = (
    # -2 tanh 1
    Force({"F_c": 2.0, "v_0": 0.02}, v=-0.02, force=-1.5231883119115297),
)
