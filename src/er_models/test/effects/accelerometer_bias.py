"""Bias of the accelerometers, worked by hand."""

from worked import Ride

WORKED = (Ride({"b_s": 0.5, "b_us": -0.25}, reported=(-7.5, 11.75)),)
