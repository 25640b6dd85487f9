"""A model for programs without Python: C code and FMI co-simulation units, from the kernel's own source."""
