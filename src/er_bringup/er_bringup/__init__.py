"""Starts the whole graph: launch files, configuration, demonstration, graph check."""
