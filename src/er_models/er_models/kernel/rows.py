"""What the workspace of the states holds.

The text below the marker is compiled together with the equations of a catalogue (`kernel.compose`).
"""

from __future__ import annotations

# --- below this line: compiled with the composed equations ---
ROWS = 21
W0, R0, G0, W, R, G, TRY, LAST, MISS, LOW, HIGH, SLOPE, Z, DECAY, ONE, TWO = range(16)
"""Rows of the workspace s (ROWS, n_states): state, rate and drive at the left end of the step; the same at its right
end; what the search for the states that feed back needs; and the weights last used, which a constant rate keeps."""
SPEED, SPEED_THEN, SPEED_LAST, YIELDING, LARGEST = range(16, ROWS)
"""Rows of the rest of the force alone: velocity of the damper, before the step, and in the trial before [m/s], by how
much the rest rises as that falls [N s/m], and the largest force so far [N]."""
