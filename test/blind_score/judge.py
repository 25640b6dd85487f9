"""What a verdict is worth, from what was hidden and what was said."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Row = Mapping[str, Any]
"""One line of a results file."""

CERTAIN = "missing_effect"
HONEST = ("unknown_effect", "partial")


def tied(effect: str, groups: Sequence[Sequence[str]]) -> bool:
    """Whether an effect is one of two that the data are said not to tell apart."""
    return any(effect in group and len(group) <= 2 for group in groups)


def single(row: Row) -> str:
    """first, tied (in a set of two), later (behind a wrong name), silent, or wrong."""
    (effect,), names = row["hidden"], row["names"]
    if names[:1] == [effect]:
        return "first"
    if tied(effect, row["alternatives"]):
        return "tied"
    return "later" if effect in names else "wrong" if names else "silent"


def false_names(row: Row) -> list[str]:
    """Names given that were not hidden and do not stand for a hidden one in a set of two."""
    hidden, groups = row["hidden"], row["alternatives"]
    excused = {
        n for g in groups if len(g) <= 2 and set(g) & (set(hidden) - set(row["names"])) for n in g
    }
    return [n for n in row["names"] if n not in hidden and n not in excused]


def pair(row: Row) -> str:
    """both, one, none or wrong (a name that was not hidden, whatever else was named)."""
    if false_names(row):
        return "wrong"
    found = [e for e in row["hidden"] if e in row["names"] or tied(e, row["alternatives"])]
    return ("none", "one", "both")[len(found)]


def complete(row: Row) -> str:
    """right (nothing named), else wrong."""
    return "wrong" if row["names"] else "right"


def outside(row: Row) -> str:
    """right (it says that something unknown remains), silent (adequate) or wrong (a certain name)."""
    if row["verdict"] in HONEST:
        return "right"
    return "wrong" if row["names"] else "silent"


def degenerate(row: Row) -> str:
    """named (rightly), modest (no certain name), or wrong (a certain name that was not hidden)."""
    if row["verdict"] != CERTAIN:
        return "modest"
    return "wrong" if set(row["names"]) - set(row["hidden"]) else "named"


JUDGES = {
    "singles": single,
    "pairs": pair,
    "complete": complete,
    "outside": outside,
    "degenerate": degenerate,
}


def judged(row: Row) -> str:
    """The judgement of a row of any kind; ``failed`` where the lab gave no answer."""
    return "failed" if row.get("failed") else JUDGES[row["kind"]](row)
