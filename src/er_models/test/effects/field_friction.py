"""Friction that grows with the field, worked by hand."""

from worked import Force

WORKED = (
    # -10 0.3 tanh 1
    Force({"F_u": 10.0, "v_0": 0.02}, v=-0.02, u=0.3, force=-2.2847824678672946),
)
