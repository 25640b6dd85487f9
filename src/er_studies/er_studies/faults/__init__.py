"""The fault estimator on random drives, beside other estimators and beside what any could know."""
