"""Controllers of the semi-active damper: skyhook."""
