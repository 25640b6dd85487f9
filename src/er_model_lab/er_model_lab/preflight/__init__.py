"""What is asked of measurements before anything is fitted to them."""
