"""Friction that grows with the load, worked by hand."""

from worked import Force

WORKED = (
    # 100 N/m 30 mm tanh 1
    Force(
        {"k_f": 100.0, "x_c": -0.02, "v_0": 0.02}, x=0.01, v=0.02, force=3.0 * 0.7615941559557649
    ),
    # the same load on the other side, moving back
    Force(
        {"k_f": 100.0, "x_c": 0.04, "v_0": 0.02}, x=0.01, v=-0.02, force=-3.0 * 0.7615941559557649
    ),
)
SHOWN = {"k_f": 400.0, "x_c": 0.003, "v_0": 0.004}
