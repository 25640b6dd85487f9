"""Preload or force bias, worked by hand."""

from worked import Force

WORKED = (Force({"F_0": 1.5}, force=1.5),)
