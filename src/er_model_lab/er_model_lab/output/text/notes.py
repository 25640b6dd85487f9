"""Notes in the order of what they change: the verdict, what the model is good for, the data, the rest."""

from __future__ import annotations

import re
from collections.abc import Iterable

WEIGHTS = (
    # the verdict may be wrong: another damper, a wrong unit, data that are lost or contradict one another
    r"times the predicted one|sensor's zero|expected .*, found|cannot be read|left out|the same samples|changed after",
    # what the model is good for
    r"errs by|s searched|are left of the held-out|go beyond|beyond what|not added|taken out again|held constant|lags |"
    r"rests on",
    # what was done to the data
    r"wild|stands? alone|dropped|resampled|filtered|bridged|cut |hole|derived|fused|uneven|went on|not explained",
)
"""Words of a note by what it changes, most important first."""
SMALL = 2
"""Weight from which on a note does not change the result."""
_WEIGHTS = tuple(map(re.compile, WEIGHTS))


def weight(note: str) -> int:
    """How little a note changes: 0 the verdict, 1 what the model is good for, 2 the data, 3 nothing of these."""
    return next((k for k, words in enumerate(_WEIGHTS) if words.search(note)), len(WEIGHTS))


def by_weight(notes: Iterable[str]) -> list[str]:
    """Each note once, most important first, in their own order where they weigh alike."""
    return sorted(dict.fromkeys(notes), key=weight)
