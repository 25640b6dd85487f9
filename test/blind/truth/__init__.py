"""The hidden effects, one a file; each with its own form of the law."""
