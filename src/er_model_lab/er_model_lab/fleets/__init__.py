"""Many dampers: each recording and each unit by itself, then all of them beside one another."""
