"""Friction that differs by direction, worked by hand."""

from worked import Force

WORKED = (
    # 2 tanh 1 in extension, -4 tanh 1 in compression
    Force({"F_e": 2.0, "F_c": 4.0, "v_0": 0.02}, v=0.02, force=1.5231883119115297),
    Force({"F_e": 2.0, "F_c": 4.0, "v_0": 0.02}, v=-0.02, force=-3.0463766238230594),
)
