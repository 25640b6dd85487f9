"""``er bench fleet [PART ...]``: what a fleet costs; -h shows all arguments."""

from __future__ import annotations

import asyncio
import json
import sys
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from er_models.files import load_model
from er_models.model import Model
from er_models.one_line import OneLine

from er_studies.bench.fleet.cluster import simulated
from er_studies.bench.fleet.data import fleet
from er_studies.bench.fleet.measure import client, compared, costs, recorded
from er_studies.bench.machine import machine

PARTS = {
    "workers": "a plain loop, one and two workers: time and memory",
    "cluster": "client, scheduler and workers of clusters that are simulated with the times measured here",
}
CLUSTERS = (100, 300, 1000, 3000)
TIMED = 20
"""Recordings whose times the simulated workers take."""


def main(arguments: list[str] | None = None) -> None:
    """Measure the parts that are named, or all, and print their tables."""
    parser = OneLine(prog="er bench fleet", description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--model", type=Path, default=Path("config/dampers/inove_guo.yaml"))
    parser.add_argument("--units", type=int, default=200)
    parser.add_argument("--recordings", type=int, default=5, help="of a unit")
    parser.add_argument("--seconds", type=float, default=60.0, help="of a recording")
    parser.add_argument("--search", action="store_true", help="diagnose every unit; else refit")
    parser.add_argument(
        "--simulate", type=int, default=1_000_000, help="recordings on the clusters"
    )
    parser.add_argument("--clusters", type=int, nargs="+", default=CLUSTERS, help="their workers")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures")
    given = parser.parse_args(arguments)
    unknown = [name for name in given.parts if name not in PARTS]
    if unknown:
        parser.error(f"PART: expected some of {', '.join(PARTS)}, found '{unknown[0]}'")
    model, found = load_model(given.model), dict[str, list[dict[str, Any]]]()
    with tempfile.TemporaryDirectory() as place:
        data = Path(place)
        fleet(model, data, given.units, given.recordings, given.seconds, given.seed)
        rows = {
            "workers": lambda: workers(data, model, search=given.search),
            "cluster": lambda: clusters(data, model, given.clusters, given.simulate),
        }
        for name in given.parts or PARTS:
            found[name] = _printed(f"{name}: {PARTS[name]}", rows[name]())
    here = machine()
    found["machine"] = _printed("machine", [dict(zip(here.head, here.rows[0], strict=True))])
    if given.json:
        given.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def workers(data: Path, model: Model, *, search: bool) -> Iterator[dict[str, Any]]:
    """Lines of the loop and of one and two workers, with ratios to the loop and to one worker."""
    found = compared(
        data, model, (0, 1, 2), search=search, said=lambda line: sys.stderr.write(f"{line}\n")
    )
    loop, one, _ = found
    for line in found:
        yield {
            **asdict(line), "overhead": line.wall / loop.wall - 1.0,
            "faster": one.wall / line.wall,
        }  # fmt: skip


def clusters(
    data: Path, model: Model, sizes: Iterable[int], recordings: int
) -> Iterator[dict[str, Any]]:
    """Lines of simulated clusters, after what they are simulated with."""
    times, row = recorded(data, model, TIMED)
    each, grown = client(model, row, min(recordings, 20_000))
    cost = costs(model, times, each)
    sys.stdout.write(
        f"a recording {times.mean():.2f} s at a worker and {1e3 * each:.2f} ms at the client, a batch"
        f" {1e3 * cost.batch:.1f} ms at the client; passing its result on {1e3 * cost.gather:.1f} ms of the scheduler;"
        f" {grown:.0f} MB of the client for 20 000 recordings\n\n"
    )
    for size in sizes:
        yield asdict(asyncio.run(simulated(size, recordings, cost)))


def _printed(title: str, rows: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows as a Markdown table, each as it comes; all of them."""
    sys.stdout.write(f"## {title}\n\n")
    kept: list[dict[str, Any]] = []
    for row in rows:
        if not kept:
            sys.stdout.write(f"| {' | '.join(row)} |\n|{'---|' * len(row)}\n")
        told = (f"{v:.3g}" if isinstance(v, float) else str(v) for v in row.values())
        sys.stdout.write(f"| {' | '.join(told)} |\n")
        sys.stdout.flush()
        kept.append(row)
    sys.stdout.write("\n")
    return kept


if __name__ == "__main__":
    main()
