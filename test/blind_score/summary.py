"""Tables of what a results file says: shares with Wilson intervals against the targets, effects, and misses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from er_studies.given_out import table

from test.blind_score.cases import KINDS
from test.blind_score.judge import Row, judged
from test.blind_score.tables import wilson

BEST = {"singles": "first", "pairs": "both", "complete": "right", "outside": "right"}
"""Judgement that leaves nothing to ask, by kind; a poor record leaves nothing to ask unless it is ``wrong``."""


@dataclass(frozen=True)
class Target:
    """A share that must be at least (or at most) so large."""

    kind: str
    what: str
    counted: tuple[str, ...]
    limit: float
    at_least: bool = True


TARGETS = (
    Target("singles", "the hidden effect named first", ("first",), 0.95),
    Target("singles", "named first, or in a tie of two", ("first", "tied"), 0.98),
    Target("pairs", "both effects named", ("both",), 0.85),
    Target("pairs", "a wrong name", ("wrong", "failed"), 0.08, at_least=False),
    Target("complete", "a false name", ("wrong", "failed"), 0.01, at_least=False),
    Target("outside", "said that something unknown remains", ("right",), 0.95),
    Target("degenerate", "a wrong certain name", ("wrong", "failed"), 0.0, at_least=False),
)
MEDIAN_RATIO, WORST_RATIO = 1.10, 1.30


def share_row(target: Target, rows: Sequence[Row]) -> list[str]:
    """One target: how often, interval, limit, and whether it is met."""
    kind = [r for r in rows if r["kind"] == target.kind]
    hits = sum(judged(r) in target.counted for r in kind)
    low, high = wilson(hits, len(kind))
    share = hits / len(kind) if kind else 0.0
    met = share >= target.limit if target.at_least else share <= target.limit
    return [
        target.kind,
        target.what,
        f"{hits}/{len(kind)}",
        f"{share:.1%}",
        f"{low:.1%} to {high:.1%}",
        f"{'at least' if target.at_least else 'at most'} {target.limit:.0%}",
        "yes" if met else "no",
    ]


def ratio(row: Row) -> float:
    """Error on fresh data over the truth's error there."""
    return float(row["fresh"]["model"] / row["fresh"]["truth"])


def ratio_rows(rows: Sequence[Row]) -> list[list[str]]:
    """The falling error: median of all, worst of the rightly named."""
    all_ = [ratio(r) for r in rows if "fresh" in r]
    right = [r for r in rows if "fresh" in r and judged(r) == "first"]
    within = [ratio(r) for r in right if not r["fresh"]["beyond"]]
    if not all_:
        return []

    def line(
        what: str, values: list[float], which: Callable[[list[float]], float], limit: float
    ) -> list[str]:
        value = which(values) if values else float("nan")
        spread = (
            f"{np.quantile(values, 0.05):.3f} to {np.quantile(values, 0.95):.3f}"
            if values
            else "-"
        )
        met = "yes" if value <= limit else "no"
        return [
            "singles",
            what,
            str(len(values)),
            f"{value:.3f}",
            spread,
            f"at most {limit:.2f}",
            met,
        ]

    return [
        line(
            "error on fresh data over the truth's: median",
            all_,
            lambda v: float(np.median(v)),
            MEDIAN_RATIO,
        ),
        line("the same, rightly named: worst", [ratio(r) for r in right], max, WORST_RATIO),
        line("the same, of fresh data within what was recorded: worst", within, max, WORST_RATIO),
    ]


def targets(rows: Sequence[Row]) -> str:
    """Every target whose kind was tried."""
    kinds = {r["kind"] for r in rows}
    lines = [share_row(t, rows) for t in TARGETS if t.kind in kinds] + ratio_rows(rows)
    head = ["kind", "what", "cases", "found", "95 % interval", "target", "met"]
    return table(head, lines)


def by_hidden(rows: Sequence[Row]) -> str:
    """One line for what was hidden alone: judgements, errors and time."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        if row["kind"] != "pairs":
            name = "+".join(row["hidden"]) or "nothing"
            label = name if row["kind"] != "degenerate" else f"{row['program']}"
            groups.setdefault(label, []).append(row)
    lines = []
    for name, group in groups.items():
        counts = Counter(judged(r) for r in group)
        ratios = [ratio(r) for r in group if "fresh" in r]
        rises = [r["rise_together"] for r in group if r["hidden"]]
        lines.append([
            name,
            str(len(group)),
            ", ".join(f"{k} {v}" for k, v in counts.most_common()),
            f"{np.median(rises):.0%}" if rises else "-",
            f"{np.median(ratios):.3f}" if ratios else "-",
            f"{max(ratios):.3f}" if ratios else "-",
            f"{np.median([r['time'] for r in group]):.0f}",
        ])  # fmt: skip
    head = [
        "hidden",
        "cases",
        "judged",
        "rise, median",
        "error over truth's, median",
        "worst",
        "time [s]",
    ]
    return table(head, lines)


def missed(row: Row) -> bool:
    """Whether something is left to ask of this row."""
    word = judged(row)
    return (
        word in ("wrong", "failed") if row["kind"] == "degenerate" else word != BEST[row["kind"]]
    )


def misses(rows: Sequence[Row]) -> str:
    """Every row that is not as it should be."""
    lines = [
        [
            r["key"],
            judged(r),
            r.get("verdict", r.get("failed", "")),
            " ".join(r.get("names", [])) or "-",
            " / ".join(" ".join(g) for g in r.get("alternatives", [])) or "-",
            f"{r['rise_together']:.0%}" if r["hidden"] else "-",
        ]
        for r in rows
        if missed(r)
    ]
    return table(["case", "judged", "verdict", "named", "alternatives", "rise"], lines)


def ordered(rows: Iterable[Row]) -> list[Row]:
    """Rows by kind, then as they were hidden, then by seed."""
    return sorted(
        rows, key=lambda r: (KINDS.index(r["kind"]), r["hidden"], r["program"], r["seed"])
    )


def page(rows: Sequence[Row], heading: str) -> str:
    """The whole result as Markdown."""
    return (
        f"{heading}\n\n{targets(rows)}\n## By what was hidden\n\n{by_hidden(rows)}\n"
        f"## Every row that is not as it should be\n\n{misses(rows)}"
    )
