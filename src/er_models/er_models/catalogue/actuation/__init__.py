"""Effects between the duty command and the field in the fluid."""
