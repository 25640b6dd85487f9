"""Friction that differs by direction, worked by hand."""

from worked import Force

WORKED = (
    # 2 tanh 1, whatever the direction
    Force({"F_a": 2.0, "v_0": 0.02}, v=0.02, force=1.5231883119115297),
    Force({"F_a": 2.0, "v_0": 0.02}, v=-0.02, force=1.5231883119115297),
)
