"""Stribeck friction, worked by hand."""

from worked import Force

WORKED = (
    # (1 + 2 / e) tanh 2
    Force({"F_c": 1.0, "F_s": 2.0, "v_s": 0.1, "v_0": 0.05}, v=0.1, force=1.6733194349401157),
    # Hess and Soom: (1 + 2 / (1 + 2^2)) tanh 4
    Force(
        {"F_c": 1.0, "F_s": 2.0, "v_s": 0.1, "v_0": 0.05, "s": 1.0},
        v=0.2,
        force=1.3990610196346938,
    ),
    # Gauss: (1 + 2 exp(-2^2)) tanh -4
    Force(
        {"F_c": 1.0, "F_s": 2.0, "v_s": 0.1, "v_0": 0.05, "s": -1.0},
        v=-0.2,
        force=-1.0359360089089718,
    ),
)
SHOWN = {"F_c": 1.0, "F_s": 3.0, "v_s": 0.05, "v_0": 0.01}
