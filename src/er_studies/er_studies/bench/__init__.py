"""What things cost: time, memory, processor."""
