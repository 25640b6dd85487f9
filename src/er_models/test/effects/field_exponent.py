"""Field exponent, worked by hand."""

from worked import YIELD, Force

WORKED = (
    # 20 N at half of 0.5 duty: 20 0.5 (1 / 2)^2 N
    Force({"b": 2.0, "u_r": 0.5}, YIELD, v=0.1, u=0.25, force=2.5),
)
