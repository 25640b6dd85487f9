"""Elastic friction with play in series, worked by hand."""

import math

from worked import Rate, Stroke

BRAKE = {"F_h": 2.0, "F_u": 10.0, "z_y": 1e-3, "b": 5e-4}
WORKED = (
    # half a bristle behind the play: (2 + 3) N / 2, and half of the velocity slides
    Rate(BRAKE, w=-1e-3, v=-0.1, u=0.3, rate=-0.05, force=-2.5),
    # half of it elastic: half of the rest beyond
    Rate({**BRAKE, "e": 0.5}, w=-1.25e-3, v=-0.1, u=0.3, rate=-0.05, force=-3.75),
    # it grips 1.4 times in extension and 0.6 times in compression
    Rate({**BRAKE, "g": 0.4}, w=-1e-3, v=-0.1, u=0.3, rate=-0.05, force=-1.5),
    Rate({**BRAKE, "g": 0.4}, w=1e-3, v=0.1, u=0.3, rate=0.05, force=3.5),
    # within the play
    Rate(BRAKE, w=3e-4, v=-0.1, u=0.3, rate=-0.1, force=0.0),
    # 5 mm from the middle of the play, 4.5 mm of them with the bristle
    Stroke(BRAKE, v=0.1, force=2.0 * (1.0 - math.exp(-4.5))),
)
SHOWN = {"F_h": 4.0, "F_u": 8.0, "z_y": 6e-4, "e": 0.4, "b": 8e-4, "g": -0.3}
