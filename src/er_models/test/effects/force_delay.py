"""Time offset of the force channel, worked by hand."""

from worked import Delay

WORKED = (Delay({"d": -0.0042}, -0.0042),)
