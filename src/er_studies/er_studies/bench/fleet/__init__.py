"""What a fleet costs: with one worker, with two, and on a cluster that is simulated."""
