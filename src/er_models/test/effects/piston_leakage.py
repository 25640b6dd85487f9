"""Leakage across the piston, worked by hand."""

from worked import PASSIVE, YIELD, Force

WORKED = (
    # half the velocity each: 2.5 N drive 0.05 m/s through 50 Ns/m, and 0.1 m/s (2.5 / 10)^(1/2) through the bleed
    Force({"v_l": 0.1, "F_r": 10.0}, PASSIVE, v=0.1, force=2.5),
    # springs are no part of it; the other way
    Force({"v_l": 0.1, "F_r": 10.0}, PASSIVE, x=0.01, v=-0.1, force=1.0 - 2.5),
    # 4 N of yield force where the bleed passes 0.05 m/s at 1 N: s^2 / 40 + s / 20 = 0.1 with s^2 the force
    Force(
        {"v_l": 0.05, "F_r": 1.0},
        {"passive": {"k0": 100.0, "c0": 0.0}, **YIELD},
        v=0.1,
        u=0.2,
        force=(5.0**0.5 - 1.0) ** 2,
    ),
)
SHOWN = {"v_l": 0.03, "F_r": 20.0}
