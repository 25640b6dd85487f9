"""Damped play of the piston, worked by hand."""

from worked import Rate, Stroke

WORKED = (
    # open: 6 tanh(100 9 mm + 10 (v - f_y / 100)), with v such that it is 6 tanh 1
    Rate(
        {"b": 0.002, "c_p": 100.0},
        {"guo_yield": {"f_c": 20.0, "k1": 100.0, "c1": 10.0}},
        w=0.001,
        x=0.01,
        v=0.05569564935734589,
        u=0.3,
        rate=0.04569564935734589,
        force=4.569564935734589,
    ),
    # closed: 6 tanh(100 (2.5 - 0.5) mm + 16 0.05 m/s)
    Stroke(
        {"b": 5e-4, "c_p": 20.0},
        {"guo_yield": {"f_c": 20.0, "k1": 100.0, "c1": 16.0}},
        v=0.05,
        u=0.3,
        force=4.569564935734589,
    ),
)
