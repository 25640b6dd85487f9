"""Observers of the damper force, and the offline synthesis of their gains."""
