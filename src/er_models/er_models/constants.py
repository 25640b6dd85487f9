"""Physical constants, under their symbols."""

g = 9.80665
"""Standard acceleration of free fall [m/s2]."""
