"""Self-heating, worked by hand."""

from worked import PASSIVE, YIELD, Rate

WORKED = (
    # 2 W above rest: 5 N e^-0.2 viscous, 6 N e^-0.1 yield
    Rate(
        {"t_h": 10.0, "b_v": 0.1, "b_y": 0.05},
        {**PASSIVE, **YIELD},
        w=2.0,
        v=0.1,
        u=0.3,
        rate=(0.1 * 9.522678273605667 - 2.0) / 10.0,
        force=9.522678273605667,
    ),
)
