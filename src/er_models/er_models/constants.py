"""Constants that several packages share: those of physics under their symbols, those of the rig under their names."""

g = 9.80665
"""Standard acceleration of free fall [m/s2]."""
SAMPLE_TIME = 0.005
"""Sample time of the testbench and of the control loop [s] (thesis, section 1.3); data and rigs may say another."""
SAMPLE_RATE = 1.0 / SAMPLE_TIME
"""Samples per second of the same [Hz]."""
