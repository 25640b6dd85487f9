"""Yield force of the electrorheological fluid by direction (Bingham), worked by hand."""

from worked import Force

WORKED = (
    # in release: 16 N / 4
    Force(
        {"sigma_c": 10.0, "beta_c": 0.5, "sigma_r": 16.0, "beta_r": 1.0, "v_0": 1e-3},
        v=0.1,
        u=0.25,
        force=4.0,
    ),
)
