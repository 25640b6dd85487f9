"""Many runs: fits begin on stretches that together cover best what all of them hold.

Only where a fit starts, and which candidates are worth a fit to all, is learnt on them; whatever is compared, judged
or written comes from all runs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from er_models.prediction import Motion
from er_records.record import Record
from numpy.typing import NDArray

from er_model_lab.problem.stretches import STRETCH, chosen

MANY, PRACTISED = 150.0, 75.0
"""Length of several runs together [s] from which fits begin on stretches of them, and that of these stretches."""


def stretches_to_practise_on(
    motion: Motion, runs: Sequence[tuple[int, int]]
) -> list[NDArray[np.intp]] | None:
    """Rows of each stretch to practise on; None where the data are short, or one run.

    runs: rows (from, to) of each.
    """
    if motion.n * motion.dt <= MANY or len(runs) < 2:
        return None
    budget = round(PRACTISED / motion.dt)
    places = chosen([_as_record(motion, *run) for run in runs], budget, STRETCH[0])
    return [np.arange(p.i, p.j) + runs[p.record][0] for p in places]


def _as_record(motion: Motion, i: int, j: int) -> Record:
    """What rows i to j exercise."""
    names = {"deflection": "x", "deflection_velocity": "v", "duty": "u", "temperature": "theta"}
    channels = {name: getattr(motion, short)[i:j] for name, short in names.items()}
    return Record(f"rows {i} to {j}", motion.t[i:j], channels)
