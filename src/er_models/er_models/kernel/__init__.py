"""Compiled kernels: composes the equations of a catalogue into one function and integrates it."""
