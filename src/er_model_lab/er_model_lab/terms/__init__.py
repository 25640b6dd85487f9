"""What remains after the catalogue's effects, learnt as one smooth term: measured, not explained."""
