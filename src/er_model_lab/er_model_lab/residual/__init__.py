"""What a model leaves: its errors, where they are largest, and what they depend on."""
