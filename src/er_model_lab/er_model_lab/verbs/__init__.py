"""What each command of the lab does, apart from how it is called; one file each."""
