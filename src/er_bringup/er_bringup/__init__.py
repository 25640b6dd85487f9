"""Starts the whole graph: launch files, configuration, the demonstration and the graph check."""
