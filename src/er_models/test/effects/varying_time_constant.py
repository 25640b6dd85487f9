"""Varying time constant, worked by hand."""

from worked import YIELD, Rate

WORKED = (
    # (6 - 1) N / (0.05 s (1 + 5 0.3 + 10 0.3^2))
    Rate(
        {"g": 5.0, "h": 10.0},
        {**YIELD, "response": {"tau": 0.05}},
        w=1.0,
        v=0.1,
        u=0.3,
        rate=29.411764705882355,
        force=1.0,
    ),
)
