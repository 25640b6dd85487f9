"""What a fit is asked: fused motion, force, masks and folds, and how a model predicts it."""
