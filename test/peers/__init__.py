"""What a user would pick instead of the lab, on the same blind measurements and the same fused motion."""
