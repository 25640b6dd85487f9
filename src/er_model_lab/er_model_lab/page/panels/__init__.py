"""What a user does, panel by panel."""
