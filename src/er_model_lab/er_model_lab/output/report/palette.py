"""Colours that stay apart for colour-blind readers and in grey print (Okabe and Ito 2008)."""

from __future__ import annotations

INK = "#1f2933"
MUTED = "#5f6b7a"
RULE = "#d9dee5"

MEASURED = "#2b2b2b"
BEFORE = "#d55e00"
AFTER = "#0072b2"
FLOOR = "#009e73"
HELD_OUT = "#f2e2a0"
RESIDUAL = "#9aa5b1"

MODELS: tuple[str, ...] = ("#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
"""Colours of models that are set side by side, in their order."""

STATUS: dict[str, str] = {
    "present": "#0072b2",
    "confounded": "#e69f00",
    "not_excited": "#b8bfc8",
    "absent": "#7d8896",
    "outdone": "#56b4e9",
    "minor": "#56b4e9",
}
"""Colour of a candidate by its status; the status is always written beside it too."""

VERDICT: dict[str, str] = {
    "adequate": "#00785a",
    "missing_effect": "#0072b2",
    "ambiguous": "#9a6a00",
    "partial": "#9a6a00",
    "unknown_effect": "#b04a00",
    "insufficient_data": "#5f6b7a",
    "identified": "#00785a",
    "identified_in_part": "#9a6a00",
    "told_apart": "#00785a",
    "one_way": "#9a6a00",
    "not_told_apart": "#b04a00",
    "revealed": "#00785a",
    "not_revealed": "#b04a00",
    "usable": "#00785a",
    "not_usable": "#b04a00",
}
"""Colour of the banner by verdict; all are dark enough for white text (contrast above 4.5)."""

LEVELS: dict[str, str] = {
    "fail": "#b04a00",
    "warning": "#9a6a00",
    "note": "#5f6b7a",
    "ok": "#00785a",
}
"""Colour of a finding by its level; the level is always written beside it too."""

Stops = tuple[tuple[float, str], ...]

DUTY: Stops = (
    (0.0, "#440154"), (0.25, "#3b528b"), (0.5, "#21918c"), (0.75, "#5ec962"), (1.0, "#c8d400"),
)  # fmt: skip
"""Sequential scale of the duty: viridis, cut where it fades on white."""

CORRELATION: Stops = (
    (0.0, "#d55e00"), (0.25, "#f2b27f"), (0.5, "#f7f7f7"), (0.75, "#7fb8d9"), (1.0, "#0072b2"),
)  # fmt: skip
"""Diverging scale of a correlation: pale where there is none."""

COVER: Stops = ((0.0, "#e3edf7"), (0.5, "#6aaed6"), (1.0, "#08306b"))
"""Sequential scale of time spent: pale where there is little."""

SIGNED: Stops = (
    (0.0, "#0072b2"), (0.25, "#7fb8d9"), (0.5, "#f7f7f7"), (0.75, "#f2b27f"), (1.0, "#d55e00"),
)  # fmt: skip
"""Diverging scale of a force: pale where there is none."""

ERROR: Stops = (
    (0.0, "#f3f6fa"), (0.25, "#fdd49e"), (0.5, "#fc8d59"), (0.75, "#d7301f"), (1.0, "#7f0000"),
)  # fmt: skip
"""Sequential scale of an error: pale where there is little, dark where there is much."""
