"""Field-dependent viscosity, worked by hand."""

from worked import Force

WORKED = (Force({"c_u": 100.0}, v=0.1, u=0.3, force=3.0),)
