"""Workspace support behind ``./er``: environment, build and command dispatch; standard library only."""
