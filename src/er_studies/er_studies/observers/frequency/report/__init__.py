"""Pictures of the frequency responses."""
