"""Jobs of a search handed out to threads, processes or clusters, and what they share."""
