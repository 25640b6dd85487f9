"""End stop (bump rubber), worked by hand."""

import numpy as np
from models_help import SMALL, imposed
from worked import Force

WORKED = (
    Force({"k_b": 1000.0, "x_b": 0.008, "k_c": 0.0}, x=-0.01, force=-2.0),
    Force({"k_b": 1000.0, "x_b": 0.008, "k_c": 5e5}, x=0.01, force=4.0),
)
SHOWN = {"x_b": 0.8 * float(np.abs(imposed(SMALL, 6.0).x).max())}
