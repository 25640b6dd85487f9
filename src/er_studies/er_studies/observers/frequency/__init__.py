"""Frequency responses of the observers' errors: the figures of chapters 3 to 5 for ours."""
