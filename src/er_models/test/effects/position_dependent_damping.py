"""Position-dependent damping, worked by hand."""

from worked import Force

WORKED = (Force({"c_x": 1e5}, x=-0.01, v=0.2, force=2.0),)
