"""Shear thinning or thickening, worked by hand."""

from worked import Force

WORKED = (
    # at 3^(1/2) times its velocity: a factor of (1 + 3)^(-1/4)
    Force(
        {"n": 0.5, "v_r": 0.1},
        {"passive": {"k0": 0.0, "c0": 100.0}},
        v=0.1 * 3.0**0.5,
        force=100.0 * 0.1 * 3.0**0.5 * 0.5**0.5,
    ),
)
