"""Fading force (loss of fluid, ageing), worked by hand."""

from worked import PASSIVE, YIELD, Rate

WORKED = (
    # no state: 1 N stiffness, 5 N viscous, 6 N yield and 2 N preload, (1 - 0.4 (1 - 1 / e))
    Rate(
        {"s": 0.4, "t_f": 10.0}, {**PASSIVE, **YIELD, "preload": {"F_0": 2.0}}, x=0.01, v=0.1, u=0.3, t=10.0,
        rate=0.0, force=10.460124870560078,
    ),
)  # fmt: skip
