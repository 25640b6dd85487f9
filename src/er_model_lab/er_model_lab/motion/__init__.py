"""One motion from several sensors: the smoother, its compiled chain, drift, and how alike a motion repeats."""
