"""Faults of the damper, thesis section 6.2: part of the catalogue, never candidates of the diagnosis."""
