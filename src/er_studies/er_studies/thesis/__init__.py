"""What the thesis shows, made again in simulation."""
