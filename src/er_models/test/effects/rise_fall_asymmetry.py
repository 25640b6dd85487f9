"""Rise-fall asymmetry of the response, worked by hand."""

from worked import YIELD, Rate

WORKED = (
    # 8 / (8 + 0.05 6) = 0.964, -2 / (2 + 0.006) = -0.997: -2 N / (0.05 s 2^0.980)
    Rate(
        {"r": 2.0},
        {**YIELD, "response": {"tau": 0.05}},
        w=8.0,
        v=0.1,
        u=0.3,
        rate=-20.272355763005447,
        force=8.0,
    ),
    # the same distance from the target, from below: nearly the plain time constant, 0.05 s 2^0.0363
    Rate(
        {"r": 2.0},
        {**YIELD, "response": {"tau": 0.05}},
        w=4.0,
        v=0.1,
        u=0.3,
        rate=39.006785261421854,
        force=4.0,
    ),
)
