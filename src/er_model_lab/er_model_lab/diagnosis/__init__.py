"""Which effect is missing: candidates, calibrated null, noise floor, ties, search and verdict."""
