"""Response time, quadratic in the duty, worked by hand."""

from worked import YIELD, Rate

WORKED = (
    # 6 N - 1 N, over 0.01 + 0.1 * 0.3 + 1.0 * 0.09 s
    Rate(
        {"tau_0": 0.01, "tau_1": 0.1, "tau_2": 1.0},
        YIELD,
        w=1.0,
        v=0.1,
        u=0.3,
        rate=5.0 / 0.13,
        force=1.0,
    ),
)
