"""Makes measurements of dampers of any size and kind, as rough as real ones; shares nothing with the lab."""
