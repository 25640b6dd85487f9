"""Estimators of the damper force that a practitioner would pick, one file each, behind the observers' protocol."""
