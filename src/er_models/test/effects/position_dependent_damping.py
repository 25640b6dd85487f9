"""Position-dependent damping, worked by hand."""

from worked import Force

WORKED = (
    Force({"c_x": 1e5, "b_x": 0.0}, x=-0.01, v=0.2, force=2.0),
    Force({"c_x": 1e5, "b_x": 100.0}, x=-0.01, v=0.2, force=1.0),
)
