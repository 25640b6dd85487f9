"""Rise-fall asymmetry of the response, worked by hand."""

from worked import YIELD, Rate

WORKED = (
    # 8 / (8 + 0.05 6) = 0.964: -2 N / (0.05 s 2^0.982)
    Rate(
        {"r": 2.0},
        {**YIELD, "response": {"tau": 0.05}},
        w=8.0,
        v=0.1,
        u=0.3,
        rate=-20.252110894616408,
        force=8.0,
    ),
    # the same distance from the target, from below: nearly the plain time constant, 0.05 s 2^0.0349
    Rate(
        {"r": 2.0},
        {**YIELD, "response": {"tau": 0.05}},
        w=4.0,
        v=0.1,
        u=0.3,
        rate=39.04441722605839,
        force=4.0,
    ),
)
