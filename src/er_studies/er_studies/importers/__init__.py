"""Measured data sets of other laboratories, in the lab's columns, units and signs."""
