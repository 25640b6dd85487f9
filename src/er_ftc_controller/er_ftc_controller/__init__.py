"""Controllers of the semi-active damper: Skyhook, and the fault-tolerant LPV controller."""
