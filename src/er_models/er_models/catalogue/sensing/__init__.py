"""Artefacts of the sensors: not physics of the damper, but in the data all the same."""
