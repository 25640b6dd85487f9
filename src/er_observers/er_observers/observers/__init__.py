"""Observers as pure steps: one runtime, and for each observer the name its gains are kept under."""
