"""Times of runs that take turns, so that what else the machine does meets them all, and tables of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from er_studies import given_out


@dataclass(frozen=True)
class Line:
    """One measurement: what; time [s]; its ratio to the time of what `against` names.

    n: how many samples or effects.
    """

    what: str
    seconds: float
    ratio: float | None = None
    against: str = ""
    remark: str = ""
    n: int = 0


def best(
    runs: Mapping[str, Callable[[], object]],
    seconds: float = 1.0,
    clock: Callable[[], float] = time.process_time,
) -> dict[str, float]:
    """Shortest time of each run [s]: they take turns, all once to warm up and twice at least, until time is over.

    Processor time by default: what else the machine does meets a long run and may spare a short one.
    """
    for run in runs.values():
        run()
    found = dict.fromkeys(runs, float("inf"))
    end, rounds = time.perf_counter() + seconds, 0
    while rounds < 2 or time.perf_counter() < end:
        rounds += 1
        for name, run in runs.items():
            start = clock()
            run()
            found[name] = min(found[name], clock() - start)
    return found


def table(lines: list[Line]) -> str:
    """Lines as a Markdown table."""
    rows = [(x.what, shown(x.seconds), _ratio(x), x.remark) for x in lines]
    return given_out.table(("what", "time", "ratio", "remark"), rows)


def _ratio(line: Line) -> str:
    """The ratio in words."""
    return "" if line.ratio is None else f"{line.ratio:.3g} times {line.against}"


def shown(seconds: float) -> str:
    """A time with its unit."""
    units = (("s", 1.0), ("ms", 1e-3), ("us", 1e-6))
    unit, size = next((u for u in units if seconds >= u[1]), units[-1])
    return f"{seconds / size:.3g} {unit}"
