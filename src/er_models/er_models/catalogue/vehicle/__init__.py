"""Terms and effects of the car around the damper."""
