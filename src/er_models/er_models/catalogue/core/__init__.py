"""Terms every damper model is made of: passive force, yield force and its response time."""
