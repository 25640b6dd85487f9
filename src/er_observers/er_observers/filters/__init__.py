"""Kalman filters of the model: prediction over a substep, sigma points, correction by the accelerations."""
