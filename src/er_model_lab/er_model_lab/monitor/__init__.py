"""A model beside the running damper: its error as it comes, whether it still explains, and what it lacks."""
