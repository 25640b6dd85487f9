"""Mount (bushing) compliance, worked by hand."""

from worked import CUBE, PASSIVE, Force, Rate

WORKED = (
    # w = 6 N / (100 + 100) N/m = 30 mm stretch; 3 N either side
    Force({"q": 0.01}, PASSIVE, x=0.01, v=0.1, force=3.0),
    # 4/s of 20 mm, 0.1 + 1 / 50 m/s; 2 N in the mount, and 1e6 (-10 mm)^3
    Rate({"q": 0.01}, {**PASSIVE, **CUBE}, w=0.02, x=0.01, v=0.1, rate=0.04, force=1.0),
)
