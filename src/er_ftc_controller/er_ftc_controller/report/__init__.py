"""Bode diagrams and the trade-off of the synthesis."""
