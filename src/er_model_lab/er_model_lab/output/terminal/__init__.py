"""Results as a summary that fits one screen."""
