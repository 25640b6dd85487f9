"""The vehicle as a problem: all outputs of a car from road and duty."""
