"""Observers as pure step functions of gains, state and sample."""
