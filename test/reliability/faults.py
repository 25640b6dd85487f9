"""How soon each injected fault shows, and what a fault-free run raises: all on the virtual clock."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from er_ros_common.injection import Kind
from er_studies.given_out import table as markdown

from er_common import topics
from er_damper_msgs.msg import DamperForce, PwmDuty
from test.reliability.bus import NAMES, Bus

A, X, U = topics.ACCELERATION.name, topics.DEFLECTION.name, topics.PWM_COMMAND.name
CASES: tuple[tuple[str, Kind, float], ...] = (
    (A, Kind.OFF, 0.0),
    (X, Kind.OFF, 0.0),
    (U, Kind.OFF, 0.0),
    (f"{A}.sprung", Kind.STUCK, 0.0),
    (f"{A}.unsprung", Kind.STUCK, 0.0),
    (A, Kind.STUCK, 0.0),
    (f"{X}.velocity", Kind.STUCK, 0.0),
    (A, Kind.GARBAGE, 0.0),
    (X, Kind.GARBAGE, 0.0),
    (U, Kind.GARBAGE, 0.0),
    (f"{A}.sprung", Kind.BIAS, 1.0),
    (f"{A}.sprung", Kind.BIAS, 3.0),
    (f"{A}.unsprung", Kind.BIAS, 3.0),
    (f"{X}.velocity", Kind.BIAS, 0.05),
    (A, Kind.SLOW, 50.0),
    (A, Kind.SLOW, 10.0),
    (A, Kind.DELAYED, 0.01),
    (A, Kind.DELAYED, 0.03),
    (U, Kind.DELAYED, 0.03),
    (U, Kind.DELAYED, 0.06),
    (A, Kind.INTERMITTENT, 0.5),
    (A, Kind.INTERMITTENT, 0.9),
)
SETTLED, WATCHED, SEEDS = 5.0, 2.0, 5
"""Time before a fault, time in which it is watched [s], runs of each."""


@dataclass(frozen=True)
class Delays:
    """From the fault until the estimate is not OK, is not valid, and the duty is safe [s]; inf: never."""

    doubted: float
    lost: float
    safe: float


def delays(unit: str, kind: Kind, value: float, seed: int) -> Delays:
    """One run."""
    bus = Bus((NAMES[0], "skyhook_controller"), seed=seed)
    bus.run(SETTLED)
    bus.inject(unit, kind, value)
    bus.run(WATCHED)

    def since(topic: str, wanted: Callable[[object], bool]) -> float:
        times = (h.t for h in bus.log[topic] if h.t >= SETTLED and wanted(h.message))
        return next(times, math.inf) - SETTLED

    force, duty = topics.estimated_force("unified").name, topics.PWM_APPLIED.name
    return Delays(
        since(force, lambda m: m.status != DamperForce.STATUS_OK),
        since(force, lambda m: not m.valid),
        since(duty, lambda m: m.source == PwmDuty.SOURCE_SAFE),
    )


def table() -> Iterator[str]:
    """One line a case: the longest of its runs."""
    yield "| unit | fault | estimate not OK after, ms | not valid after, ms | safe duty after, ms |"
    yield "|---|---|---|---|---|"
    for unit, kind, value in CASES:
        each = [delays(unit, kind, value, seed) for seed in range(1, SEEDS + 1)]
        words = f"{kind.name.lower()} {value:g}" if value else kind.name.lower()
        found = (
            _longest([getattr(d, name) for d in each]) for name in ("doubted", "lost", "safe")
        )
        yield f"| `{unit}` | {words} | {' | '.join(found)} |"


def _longest(times: list[float]) -> str:
    """The longest, and how many of the runs showed nothing."""
    seen = [t for t in times if math.isfinite(t)]
    if not seen:
        return "-"
    missed = len(times) - len(seen)
    return f"{1e3 * max(seen):.0f}" + (f" ({missed} of {len(times)} not at all)" if missed else "")


def alarms(seconds: int) -> tuple[int, int, int]:
    """Without faults, after the first second: estimates not valid, samples called unusable, safe duties."""
    bus = Bus((NAMES[0], "skyhook_controller"), seed=7)
    bus.run(1.0)
    invalid = safe = 0
    for _ in range(seconds):
        for log in bus.log.values():
            log.clear()
        bus.run(1.0)
        invalid += sum(
            not h.message.valid for h in bus.log[topics.estimated_force("unified").name]
        )
        safe += sum(
            h.message.source == PwmDuty.SOURCE_SAFE for h in bus.log[topics.PWM_APPLIED.name]
        )
    stuck = sum(state.unusable for state in bus.states.values())
    return invalid, stuck, safe


def run(seconds: int) -> int:
    """Print the table and the alarms of a fault-free run; 1 where there were any."""
    for line in table():
        sys.stdout.write(f"{line}\n")
        sys.stdout.flush()
    invalid, stuck, safe = alarms(seconds)
    head = ("s without a fault", "estimates not valid", "samples refused as stuck", "safe duties")
    counts = [str(n) for n in (seconds, invalid, stuck, safe)]
    sys.stdout.write(f"\n{markdown(head, [counts])}")
    return int(bool(invalid or stuck or safe))
