"""Progressive gas spring, worked by hand."""

from worked import Force

WORKED = (
    Force({"k_2": 1e4, "k_3": 2e6}, x=-0.01, v=0.1, force=-1.0),
    # half of a column of 20 mm is left; at 19 mm no less than a tenth: -9.025 / 0.1
    Force({"k_2": -1e4, "k_3": 0.0, "e_g": 50.0}, x=-0.01, v=0.1, force=-2.0),
    Force({"k_2": -2.5e4, "k_3": 0.0, "e_g": 50.0}, x=-0.019, v=0.1, force=-90.25),
)
