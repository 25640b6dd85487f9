"""Shear thinning under field (Herschel-Bulkley), worked by hand."""

from worked import Force

WORKED = (
    # -100 0.2 0.4 / 0.25^(1/4)
    Force(
        {"c_h": 100.0, "n": 0.5, "v_0": 0.03, "v_r": 0.1},
        v=-0.04,
        u=0.2,
        force=-11.313708498984761,
    ),
)
