"""Pre-sliding hysteresis (Dahl, Bouc-Wen), worked by hand."""

from worked import Force, Rate

CHAIN = {"F_h": 2.0, "F_u": 10.0, "z_y": 1e-3}
WORKED = (
    Force(CHAIN, v=-0.1, u=0.3, force=-5.0),
    # half of it elastic: within that, and half of the rest beyond
    Rate({**CHAIN, "e": 0.5}, w=-3e-4, v=-0.1, u=0.3, rate=-0.1, force=-1.5),
    Rate({**CHAIN, "e": 0.5}, w=-7.5e-4, v=-0.1, u=0.3, rate=-0.05, force=-3.75),
    Rate(CHAIN, w=-5e-4, v=-0.1, u=0.3, rate=-0.05, force=-2.5),
)
SHOWN = {"e": 0.4}
