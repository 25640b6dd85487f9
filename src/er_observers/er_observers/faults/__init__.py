"""The fault estimator: which share of its force a damper has lost, and to which fault."""
