"""Faults of the real world, in virtual time and against processes; `python -m test.reliability` for the long ones."""
