"""Measured records: read, named, cleaned, told apart, with where they come from."""
