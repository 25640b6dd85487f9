"""How the lab is called: arguments, progress, exit status."""
