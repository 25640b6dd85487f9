"""Pictures of the controllers compared."""
