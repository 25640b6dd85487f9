"""Observers and their peers on the same drives: errors, tables, pictures."""
