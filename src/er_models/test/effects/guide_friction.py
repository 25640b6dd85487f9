"""Friction of the wheel's guide, worked by hand."""

from worked import Ride

WORKED = (
    # 2 tanh 1 beside the 16 N
    Ride(
        {"F_g": 2.0, "v_0": 0.1},
        reported=(-8.0 - 0.7615941559557649, 12.0 + 4.0 * 0.7615941559557649),
    ),
)
