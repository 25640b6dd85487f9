"""Bounded least squares, estimates with their uncertainty, and within which bounds a model is valid."""
