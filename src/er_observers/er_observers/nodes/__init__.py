"""The node around an observer."""
