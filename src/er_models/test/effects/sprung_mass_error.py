"""Error of the sprung mass, worked by hand."""

from worked import Ride

WORKED = (Ride({"e": 0.6}, reported=(-5.0, 12.0)),)
