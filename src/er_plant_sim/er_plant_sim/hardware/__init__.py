"""A real rig behind a byte protocol: frames, calibration, clocks, watchdogs, and a device to test with."""
