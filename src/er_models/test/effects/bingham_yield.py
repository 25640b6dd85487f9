"""Yield force of the electrorheological fluid (Bingham), worked by hand."""

from worked import Force

WORKED = (
    # 5 tanh 2
    Force({"sigma": 10.0, "beta": 0.5, "v_0": 0.01}, v=0.02, u=0.25, force=4.820137900379084),
)
