"""Progressive gas spring, worked by hand."""

from worked import Force

WORKED = (Force({"k_2": 1e4, "k_3": 2e6}, x=-0.01, v=0.1, force=-1.0),)
