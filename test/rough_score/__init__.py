"""Scores the lab on `test/rough`, data as rough as real ones, against stated targets."""
