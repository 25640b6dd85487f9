"""The size below which an effect is none."""

SMALLEST = 0.12
"""Error, as a share of the noise, below which nothing counts: real dampers follow no equation more closely."""
