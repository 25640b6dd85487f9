"""Pictures of the controllers."""
