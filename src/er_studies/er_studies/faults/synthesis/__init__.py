"""The observer of the lost force that the fault estimator is compared with."""
