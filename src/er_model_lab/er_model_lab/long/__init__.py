"""Data longer than can be searched: what is used of them, their memory, and the check on all of them."""
