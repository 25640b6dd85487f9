"""Yield force of the electrorheological fluid by direction (Guo), worked by hand."""

from worked import Force

WORKED = (
    # compression: -15 tanh 1.5
    Force(
        {
            "f_c_c": 30.0,
            "k1_c": 100.0,
            "c1_c": 50.0,
            "f_c_r": 20.0,
            "k1_r": 10.0,
            "c1_r": 10.0,
            "v_0": 1e-3,
        },
        x=0.01,
        v=-0.05,
        u=0.5,
        force=-13.577223804673,
    ),
)
