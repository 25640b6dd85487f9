"""What every peer reads at a sample, by place in one array, and how peers are compiled.

X, V: deflection [m], its rate [m/s]; A_S, A_U: accelerations [m/s2]; V_S: leaky integral of A_S [m/s]; TYRE: its
deflection by both accelerations [m]; FORCE: yield force followed by the healthy model [N]; GATE: gate at the motion
led on to the middle of the time the duty acts; FULL: yield force of the healthy damper at duty 1 [N]; WAY: rates of
the road over the next `AHEAD` steps of `STEP` s [m/s], for who may see them.
"""

from __future__ import annotations

from er_models.cache.compiled import on_disk

X, V, A_S, A_U, V_S, TYRE, FORCE, GATE, FULL, WAY = range(10)
AHEAD, STEP = 10, 0.01
LEAST_GATE = 0.4
"""A smaller |gate| is taken for it: what no duty can make must not ask for all of it."""
compiled = on_disk(error_model="numpy")
