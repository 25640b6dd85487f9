"""Progressive suspension spring, worked by hand."""

from worked import Ride

WORKED = (
    # 8 N - 1 N
    Ride({"k_3": 1e6, "x_c": -0.01}, reported=(-11.5, 26.0)),
)
SHOWN = {"k_3": 2e7, "x_c": 0.005}
