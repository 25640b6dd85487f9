"""What an answer to a rough case is worth."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from test.blind_score.judge import CERTAIN, HONEST, tied
from test.rough.drives import POOR

Row = Mapping[str, Any]
"""One line of a results file."""
LEARNT = "measured_"
"""How names begin that claim no cause."""
GOOD = ("right", "tied")
TALKS = (*HONEST, "ambiguous", "insufficient_data")
"""Verdicts that claim no certain cause."""


def inside(row: Row) -> list[set[str]]:
    """The names that are right for each hidden effect of which the catalogue knew one, as of the row's day."""
    known = set(row["known"])
    return [known.intersection(names) for names in row["right"] if known.intersection(names)]


def poor(row: Row) -> bool:
    """Whether one tone, or one curve again and again, was all that was recorded."""
    return row["drives"][0][0] in POOR


def named(row: Row) -> list[str]:
    """What was named as a cause; terms that are learnt from the data are none."""
    return [n for n in row["names"] if not n.startswith(LEARNT)]


def held(names: Collection[str], wanted: Collection[str]) -> bool:
    """Whether one of the wanted names is among them."""
    return not set(names).isdisjoint(wanted)


def in_tie(wanted: Collection[str], groups: Sequence[Sequence[str]]) -> bool:
    """Whether one of the wanted names is one of two that the data are said not to tell apart."""
    return any(tied(n, groups) for n in wanted)


def false_names(row: Row) -> list[str]:
    """Names given that are neither right, nor true beside it, nor tied with what is right."""
    wanted = {n for names in row["right"] for n in names} | set(row["beside"])
    tie = {n for g in row["alternatives"] if len(g) <= 2 and set(g) & wanted for n in g}
    return [n for n in named(row) if n not in wanted and n not in tie]


def certain_wrong(row: Row) -> bool:
    """Whether a name that is wrong was given in a verdict that is sure, or any name to a complete model."""
    if row.get("failed"):
        return False
    return bool(false_names(row)) and (not row["right"] or row["verdict"] == CERTAIN)


def judged(row: Row) -> str:
    """right, tied (with one other), extra (right, and a false name), part, silent, modest, doubted, wrong or failed.

    Of a complete model nothing named is right, and that something unknown remains is ``doubted``. Of a poor record
    everything but a wrong certain name is right. What lies outside the catalogue is right where something is said to
    remain (``modest`` where the data are called insufficient).
    """
    if row.get("failed"):
        return "failed"
    false, names, groups = false_names(row), named(row), row["alternatives"]
    if not row["right"]:
        return "wrong" if false else "doubted" if row["verdict"] in HONEST else "right"
    if poor(row):
        return "wrong" if certain_wrong(row) else "right"
    wanted = inside(row)
    if len(wanted) < len(row["right"]):  # something that no catalogue holds
        rest = all(held(names, w) or in_tie(w, groups) for w in wanted)
        if row["verdict"] in HONEST:
            return "right" if rest else "part"
        return "wrong" if certain_wrong(row) else "modest" if row["verdict"] in TALKS else "silent"
    found = [held(names, w) for w in wanted]
    near = [f or in_tie(w, groups) for f, w in zip(found, wanted, strict=True)]
    if all(near):
        if (
            len(wanted) == 1
            and names[:1]
            and not held(names[:1], wanted[0])
            and not in_tie(wanted[0], groups)
        ):
            return "extra"
        return "extra" if false else "right" if all(found) else "tied"
    if false:
        return "wrong"
    return "part" if any(near) else "modest" if row["verdict"] in TALKS else "silent"
