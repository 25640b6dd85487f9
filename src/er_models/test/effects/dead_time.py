"""Dead time of the actuation, worked by hand."""

from worked import Delay

WORKED = (Delay({"T_d": 0.0123}, 0.0123),)
