"""Mass of the fluid and the piston that the stroke accelerates, F = m (z_s'' - z_us'').

The car's own accelerations depend on it, so both are solved together (see ``rates``).
"""

from __future__ import annotations

from test.blind.effect import Effect, nothing
from test.blind.slots import INERTIA

EFFECT = Effect("fluid_inertia", (("m", "kg"),), 0.2, 0.05, 1.0, nothing, slot=INERTIA)
