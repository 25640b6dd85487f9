"""Effects that add to or shape the damper force."""
