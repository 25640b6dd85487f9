"""The first seconds of an observer: a filter from drawn starts until the state is known."""
