"""Saturation of the field, worked by hand."""

from worked import YIELD, Force

WORKED = (
    # 20 0.25 / 1.5
    Force({"s": 2.0}, YIELD, v=0.1, u=0.25, force=10.0 / 3.0),
)
