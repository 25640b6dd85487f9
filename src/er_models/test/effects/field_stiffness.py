"""Field-dependent stiffness, worked by hand."""

from worked import Force

WORKED = (
    Force({"k_u": 1000.0, "b_u": 0.0}, x=0.01, u=0.3, force=3.0),
    Force({"k_u": 1000.0, "b_u": 75.0}, x=-0.01, u=0.3, force=-2.4),
)
