"""Cavitation, worked by hand."""

from worked import PASSIVE, Rate

WORKED = (
    # 5 N pull where 4 N can be: 1 / 50 m/s less 2 / s of 3 mm; 3 / 4 of the newton is missing
    Rate(
        {"F_v": 4.0, "r": 2.0, "w_s": 1e-3}, PASSIVE, w=3e-3, x=0.01, v=0.1, rate=0.014, force=5.25
    ),
    # all that the fluid carries: flow 5 0.841 + 1 + 2 + 1 + 3 N; springs, preload 6 N
    Rate(
        {"F_v": 4.0, "r": 0.0, "w_s": 1e-3},
        {
            **PASSIVE,
            "shear_thinning": {"n": 0.5, "v_r": 0.1},
            "quadratic_damping": {"c_2": 100.0},
            "asymmetric_damping": {"c_a": 20.0},
            "position_dependent_damping": {"c_x": 1e5, "b_x": 0.0},
            "field_viscosity": {"c_u": 100.0},
            "field_stiffness": {"k_u": 1000.0, "b_u": 0.0},
            "preload": {"F_0": 2.0},
        },
        w=3e-3,
        x=0.01,
        v=0.1,
        u=0.3,
        rate=(11.204482076268573 - 4.0) / 50.0,
        force=6.0 + 11.204482076268573 - 0.75 * (11.204482076268573 - 4.0),
    ),
    # half of the field's 3 N in the way: (4 - 1.5) / 50 m/s follow; 5 + 3 N of the fluid, 3 / 4 of 4 N are missing
    Rate(
        {"F_v": 4.0, "r": 0.0, "w_s": 1e-3, "s_y": 0.5},
        {**PASSIVE, "field_viscosity": {"c_u": 100.0}},
        w=3e-3,
        x=0.01,
        v=0.1,
        u=0.3,
        rate=0.05,
        force=6.0,
    ),
    # the pressure falls faster than that of gas: 1 - 1 / 2.5^2 of the newton is missing
    Rate(
        {"F_v": 4.0, "r": 2.0, "w_s": 1e-3, "n_g": 2.0},
        PASSIVE,
        w=3e-3,
        x=0.01,
        v=0.1,
        rate=0.014,
        force=5.16,
    ),
    # closing in compression: 1 N where -4 N would be held: -5 / 50 m/s
    Rate(
        {"F_v": -4.0, "r": 0.0, "w_s": 1e-3},
        PASSIVE,
        w=1e-3,
        x=0.01,
        v=0.02,
        rate=-0.1,
        force=-0.5,
    ),
)
