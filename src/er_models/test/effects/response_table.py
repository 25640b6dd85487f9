"""Response time, tabulated over the duty, worked by hand."""

from worked import YIELD, Rate

TABLE = {
    "u_1": 0.1, "d_u": 0.05,
    "tau_1": 0.01, "tau_2": 0.02, "tau_3": 0.04, "tau_4": 0.05, "tau_5": 0.06,
}  # fmt: skip
WORKED = (
    # duty 0.225 is the middle of 0.2 and 0.25: 45 ms
    Rate(TABLE, YIELD, w=1.0, v=0.1, u=0.225, rate=3.5 / 0.045, force=1.0),
)
