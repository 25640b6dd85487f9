"""Preload that grows with the field, worked by hand."""

from worked import Force

# 20 N per duty, at rest
WORKED = (Force({"F_u": 20.0}, u=0.3, force=6.0),)
