"""Offline synthesis of observer gains: one theorem a file, each result proved elsewhere."""
