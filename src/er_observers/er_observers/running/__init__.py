"""An observer at work: gains made ready, the steps that all observers share, and what an observer is worth."""
