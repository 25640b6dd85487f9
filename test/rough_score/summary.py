"""Tables of a rough score: shares against the targets, errors on fresh data, and every case that was missed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np
from er_studies.given_out import table

from test.blind_score.tables import wilson
from test.rough.plan import KINDS
from test.rough_score.judge import GOOD, Row, certain_wrong, judged, poor

AT_LEAST_GOOD, MOST_WRONG, MOST_COMPLETE = 0.90, 0.02, 0.01
MEDIAN_RATIO, HIGH_RATIO, HIGH_WITH_TERMS = 1.05, 1.25, 1.15
"""Error on fresh data over what the true model leaves: the median, its 90th percentile, that with measured terms."""
FUSED_OVER_FILTERED = 1.25
"""How much more the truth may err along the lab's own fused motion than along a plainly filtered one, at most."""


def ratio(row: Row) -> float:
    """Error on fresh data over what the true model leaves there, along the lab's motion unless that is the trouble."""
    fresh = row["fresh"]
    return float(fresh["model"] / min(fresh["truth"], FUSED_OVER_FILTERED * fresh["filtered"]))


def troubles(row: Row) -> str:
    """What went wrong in the records of a case."""
    bent = ["bent"] if row["wrong"][0]["bent"] else []
    return " ".join([*(w["wild"] for w in row["wrong"] if w["wild"]), *bent]) or "nothing"


def _share(what: str, hits: int, n: int, limit: float, *, at_least: bool) -> list[str]:
    """One target of a share."""
    low, high = wilson(hits, n)
    share = hits / n if n else 0.0
    met = share >= limit if at_least else share <= limit
    side = "at least" if at_least else "at most"
    return [
        what,
        f"{hits}/{n}",
        f"{share:.1%}",
        f"{low:.1%} to {high:.1%}",
        f"{side} {limit:.0%}",
        "yes" if met else "no",
    ]


def _ratio(what: str, values: Sequence[float], q: float, limit: float) -> list[str]:
    """One target of a quantile of the errors on fresh data."""
    value, spread = float(np.quantile(values, q)), np.quantile(values, [0.05, 0.95])
    said = f"{spread[0]:.3f} to {spread[1]:.3f}"
    return [
        what,
        str(len(values)),
        f"{value:.3f}",
        said,
        f"at most {limit:.2f}",
        "yes" if value <= limit else "no",
    ]


def targets(rows: Sequence[Row]) -> str:
    """All targets; the spread of a ratio is that of 90 % of its cases."""
    complete = [r for r in rows if not r["right"]]
    lines = [
        _share("right or honestly tied", sum(judged(r) in GOOD for r in rows), len(rows), AT_LEAST_GOOD, at_least=True),
        _share("a wrong certain name", sum(map(certain_wrong, rows)), len(rows), MOST_WRONG, at_least=False),
        _share(
            "complete models named", sum(map(certain_wrong, complete)), len(complete), MOST_COMPLETE, at_least=False,
        ),
    ]  # fmt: skip
    for learnt in (False, True):
        asked = [r for r in rows if "fresh" in r and not poor(r) and r["measured_terms"] == learnt]
        values = [ratio(r) for r in asked]
        within = [ratio(r) for r in asked if not r["fresh"]["beyond"]]
        word, high = (", with measured terms", HIGH_WITH_TERMS) if learnt else ("", HIGH_RATIO)
        if values:
            lines.append(
                _ratio(f"fresh error over the truth's{word}: median", values, 0.5, MEDIAN_RATIO)
            )
            lines.append(_ratio(f"the same{word}: 90th percentile", values, 0.9, high))
        if within:
            lines.append(
                _ratio(f"where the lab says nothing of its reach{word}", within, 0.9, high)
            )
    return table(["what", "cases", "found", "95 % interval", "target", "met"], lines)


def by(rows: Sequence[Row], what: Callable[[Row], str]) -> str:
    """One line for each group: judgements, errors and time."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(what(row), []).append(row)
    lines = []
    for name, group in sorted(groups.items()):
        ratios = [ratio(r) for r in group if "fresh" in r]
        count = Counter(map(judged, group))
        lines.append([
            name, str(len(group)), str(sum(count[w] for w in GOOD)),
            ", ".join(f"{k} {v}" for k, v in count.most_common()),
            f"{np.median(ratios):.3f}" if ratios else "-", f"{max(ratios):.2f}" if ratios else "-",
            f"{np.median([r['time'] for r in group]):.0f}",
        ])  # fmt: skip
    return table(["group", "cases", "good", "judged", "fresh, median", "worst", "time [s]"], lines)


def misses(rows: Sequence[Row]) -> str:
    """Every row that is not as it should be, or whose model errs by half more than the truth."""
    lines = []
    for r in rows:
        word, over = judged(r), ratio(r) if "fresh" in r else float("nan")
        if word in GOOD and not over > 1.0 + 2.0 * (HIGH_RATIO - 1.0):
            continue
        lines.append([
            r["key"], word, r["verdict"] or r.get("failed", ""), " ".join(r["names"]) or "-",
            " / ".join(" ".join(g) for g in r["alternatives"]) or "-", " ".join(f"{s:.1f}" for s in r["shown"]) or "-",
            f"{over:.2f}", f"{r['rate']:g} Hz {r['sensors']} {r['drives'][0][2]}, wrong: {troubles(r)}",
        ])  # fmt: skip
    head = ["case", "judged", "verdict", "named", "alternatives", "shown", "fresh", "recorded"]
    return table(head, lines)


def page(rows: Sequence[Row], heading: str) -> str:
    """The whole result as Markdown."""
    made = sorted(
        (r for r in rows if "unmade" not in r), key=lambda r: (KINDS.index(r["kind"]), r["key"])
    )
    if not made:
        return f"{heading}\n"
    parts = {
        "kind": lambda r: r["kind"], "what was hidden": lambda r: "+".join(r["truths"]) or "nothing",
        "device": lambda r: r["device"], "channels": lambda r: r["sensors"], "rate": lambda r: f"{r['rate']:6g} Hz",
        "what went wrong": troubles,
    }  # fmt: skip
    tables = "".join(f"## By {name}\n\n{by(made, what)}\n" for name, what in parts.items())
    unmade = [r["unmade"] for r in rows if "unmade" in r]
    rest = f"\nNot made: {'; '.join(unmade)}\n" if unmade else ""
    return f"{heading}\n\n{targets(made)}\n{tables}## Every case that is not as it should be\n\n{misses(made)}{rest}"
