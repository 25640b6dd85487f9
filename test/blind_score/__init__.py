"""Scores the lab on data whose hidden effects it was not told, against stated targets."""
