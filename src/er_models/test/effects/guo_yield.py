"""Yield force of the electrorheological fluid (Guo), worked by hand."""

from worked import Force

WORKED = (
    # 10 tanh 1.5
    Force({"f_c": 20.0, "k1": 100.0, "c1": 10.0}, x=0.01, v=0.05, u=0.5, force=9.051482536448664),
)
