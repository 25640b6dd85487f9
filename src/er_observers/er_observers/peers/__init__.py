"""What a user would pick instead of our observers: Kalman filters on the same model and the same sensors."""
