"""Benchmarks of prediction and simulation: every figure beside a reference that is measured in the same run."""
