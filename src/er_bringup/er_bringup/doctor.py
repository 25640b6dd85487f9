"""``er doctor``: looks at a running graph for a few seconds, says what is wrong and what to do.

Exit status: 0 healthy, 1 problems, 2 bad usage.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import median

from er_models.files import write_whole
from er_models.one_line import INTERRUPTED, OneLine, end_with
from er_ros_common.graph_check import Problem
from rich.console import Console
from rich.table import Table

from er_bringup.arguments import NAMESPACE, is_namespace
from er_bringup.ros_checks import Heard, Observation, plant_of, problems, real_time
from er_bringup.terminal import console

HEALTHY, UNHEALTHY = 0, 1


def namespace(text: str) -> str:
    """A namespace on the command line."""
    if not is_namespace(text):
        raise argparse.ArgumentTypeError(f"expected {NAMESPACE}, found '{text}'")
    return text


def parser() -> OneLine:
    """Options of the command."""
    p = OneLine(
        prog="er doctor",
        description="Check a running graph: types, QoS, rates, stamps, parameters, health.",
        allow_abbrev=False,
    )
    p.add_argument(
        "--namespace",
        type=namespace,
        metavar="NS",
        help="namespace of the corner; by default all that there are",
    )
    p.add_argument(
        "--seconds", type=float, default=3.0, metavar="S", help="how long to listen (3)"
    )
    p.add_argument(
        "--json", metavar="FILE", help="write the result there too; - for standard output"
    )
    return p


def rows(seen: Observation) -> list[tuple[str, ...]]:
    """One line a topic that somebody publishes or waits for; simulated stamps have no age."""
    aged = real_time(plant_of(seen))
    there = [heard for heard in seen.heard if heard.publishers or heard.subscribers]
    return [_row(heard, heard.ages if aged else ()) for heard in there]


def _row(heard: Heard, ages: Sequence[float]) -> tuple[str, ...]:
    age = f"{1e3 * median(ages):.1f}" if ages else "-"
    worst = f"{1e3 * max(ages):.1f}" if ages else "-"
    return (
        heard.name,
        ", ".join(end.node for end in heard.publishers) or "nobody",
        str(len(heard.subscribers)),
        f"{heard.rate:.1f}",
        age,
        worst,
        str(heard.lost),
    )


def document(seen: Observation, found: Sequence[Problem]) -> dict[str, object]:
    """The result for machines."""
    heads = ("topic", "publishers", "subscribers", "rate", "age_ms", "age_max_ms", "lost")
    return {
        "healthy": not found,
        "namespace": seen.namespace or "/",
        "seconds": seen.seconds,
        "topics": [dict(zip(heads, row, strict=True)) for row in rows(seen)],
        "nodes": [
            {"node": n.name, "mode": n.mode, "status": n.status, "reason": n.reason}
            for n in seen.nodes
        ],
        "problems": [asdict(problem) for problem in found],
    }


def show(seen: Observation, found: Sequence[Problem], console: Console) -> None:
    """Tables for people; names below the namespace of the title, so that they fit a terminal."""

    def near(name: str) -> str:
        return name.replace(f"{seen.namespace}/", "") if seen.namespace else name

    table = Table(title=f"graph in {seen.namespace or '/'}, {seen.seconds:g} s")
    for head in ("topic", "published by", "heard by", "Hz", "age ms", "max", "lost"):
        text = head in ("topic", "published by")
        fold = head == "published by"
        table.add_column(
            head, justify="left" if text else "right", no_wrap=not fold, overflow="fold"
        )
    for topic, sender, *rest in rows(seen):
        table.add_row(near(topic), near(sender), *rest)
    if table.row_count:
        console.print(table)
    if not found:
        console.print("healthy: nothing to report")
        return
    sick = Table(title=f"{len(found)} problem{'s' if len(found) > 1 else ''}")
    for head in ("where", "what", "cure"):
        sick.add_column(head, overflow="fold")
    for problem in found:
        sick.add_row(near(problem.topic), f"{problem.kind}: {problem.text}", problem.cure)
    console.print(sick)


def main() -> None:
    """Entry point of the command."""
    p = parser()
    options = p.parse_args()
    if not 0.1 <= options.seconds <= 600.0:
        p.error(f"--seconds: expected 0.1 to 600, found {options.seconds:g}")
    end_with("er doctor", lambda: run(options))


def run(options: argparse.Namespace) -> int:
    """Look and show as the options say; the exit status."""
    # only now: help and bad usage need no ROS
    from er_bringup.ros_listen import observe

    try:
        seen = observe(options.namespace, options.seconds)
    except KeyboardInterrupt:
        return INTERRUPTED
    found = [problems(one) for one in seen]
    documents = [document(*both) for both in zip(seen, found, strict=True)]
    text = json.dumps(together(documents), indent=1)
    if options.json == "-":
        print(text)  # noqa: T201  (asked for)
    else:
        for both in zip(seen, found, strict=True):
            show(*both, console())
        if options.json:
            write_whole(Path(options.json), text)
    return UNHEALTHY if any(found) else HEALTHY


def together(documents: Sequence[dict[str, object]]) -> dict[str, object]:
    """One document: that of the graph, or those of several graphs."""
    if len(documents) == 1:
        return documents[0]
    return {"healthy": all(d["healthy"] for d in documents), "graphs": list(documents)}


if __name__ == "__main__":
    main()
