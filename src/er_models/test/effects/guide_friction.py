"""Friction of the wheel's guide, worked by hand."""

from worked import Ride

WORKED = (
    # 2 tanh 1 beside the 16 N
    Ride(
        {"F_g": 2.0, "v_0": 0.1, "r": 0.0},
        reported=(-8.0 - 0.7615941559557649, 12.0 + 4.0 * 0.7615941559557649),
    ),
    # half of it slow: 1 (tanh 1 + 2 / pi atan 1) = tanh 1 + 1 / 2
    Ride(
        {"F_g": 2.0, "v_0": 0.1, "r": 0.5},
        reported=(-8.0 - 0.63079707797788245, 12.0 + 4.0 * 0.63079707797788245),
    ),
)
