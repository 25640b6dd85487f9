"""Results as the contract's JSON and as views that terminal and report draw."""
