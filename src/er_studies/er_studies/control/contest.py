"""Ours and its peers on roads drawn by a seed: tuned on some, scored on others, all against the passive car."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from er_ftc_controller.control import Ftc
from er_models.constants import SAMPLE_TIME as DT
from er_models.errors import ErError
from er_models.forms.loss import Factors
from er_models.model import Array, Model
from er_models.program import times, within
from er_models.road import road_profile

from er_studies.control.form_ride import Ridden, measured, ride_ours, ride_peer
from er_studies.control.peers import PEERS, Knobs

TUNED, SCORED = 5000, 1000
"""First seeds of the roads for tuning and of those that count."""
BUDGET = 60
FAULTS: Mapping[str, Factors] = {
    "healthy": Factors(), "electrical": Factors(electrical=0.5), "leakage": Factors(leakage=0.6),
    "deformation": Factors(deformation=0.6), "combined": Factors(0.7, 0.8, 0.8),
}  # fmt: skip
TONES = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0)
HEADS = ("deflection", "comfort", "tyre load", "damper force")


class Road(NamedTuple):
    """Heights at every step of the integrator [m], when counting begins [s], seed of the noise."""

    heights: Array
    begin: float
    seed: int


def iso(model: Model, seed: int, seconds: float = 8.0) -> Road:
    """Seconds of a random road, speed 10 to 30 m/s, peak deflection velocity of the passive car 0.08 to 0.25 m/s."""
    rng = np.random.default_rng([seed, 1])
    spec = {"kind": "iso8608", "road_class": "C", "speed": float(rng.uniform(10.0, 30.0))}
    return _scaled(
        model, spec, seconds, 2.0, seed, float(np.exp(rng.uniform(math.log(0.08), math.log(0.25))))
    )


def bump(model: Model, seed: int) -> Road:
    """One bump of 0.06 to 0.6 s, every other one round, else with edges of 0.1 to 0.3 of it; peak 0.15 to 0.3 m/s."""
    rng = np.random.default_rng([seed, 2])
    length = 5.0 * float(np.exp(rng.uniform(math.log(0.06), math.log(0.6))))
    edge = 0.5 if seed % 2 == 0 else float(rng.uniform(0.1, 0.3))
    spec = {
        "kind": "bumps",
        "length": length,
        "spacing": 1000.0,
        "speed": 5.0,
        "edge": edge,
        "start": 2.5,
        "count": 1,
    }
    return _scaled(model, spec, 3.5, 0.4, seed, float(rng.uniform(0.15, 0.3)))


def tone(model: Model, hertz: float) -> Road:
    """A tone of 4 mm, or of less where the passive car would be faster than 0.15 m/s; the second half counts."""
    seconds = max(4.0, math.ceil(12.0 / hertz))
    spec = {"kind": "sine", "amplitude": 0.004, "frequency": hertz}
    road = _scaled(model, spec, seconds, 0.5 * seconds, 0, 0.15)
    largest = float(np.abs(road.heights).max())
    return road._replace(heights=road.heights * min(1.0, 0.004 / largest))


def _scaled(
    model: Model, spec: Mapping[str, object], seconds: float, begin: float, seed: int, peak: float
) -> Road:
    """A road on which the passive car reaches a peak deflection velocity [m/s]."""
    heights = road_profile(spec, within(times(seconds, DT).size, DT), seed)
    record = ride_peer(Ridden(model), heights, 0, np.zeros(1), seed)
    fastest = float(np.abs(np.diff(record[:, 0])).max()) / DT
    return Road(heights * peak / fastest, begin, seed)


Rider = Callable[[Ridden, Road], Array]


def peer(model: Model, name: str, knobs: Knobs) -> Rider:
    """A peer with its knobs."""
    number, p = PEERS[name].number, PEERS[name].prepare(model, knobs)
    return lambda of, road: ride_peer(of, road.heights, number, p, road.seed)


def ours(build: Callable[[Ridden], Ftc], *, told: bool = True) -> Rider:
    """The controller within the limits of a ride."""
    return lambda of, road: ride_ours(of, road.heights, build(of), road.seed, told=told)


def scores(of: Ridden, roads: Sequence[Road], rider: Rider) -> Array:
    """The four measures on each road (roads, 4)."""
    return np.array([measured(rider(of, road), of.model, road.begin) for road in roads])


def passive(of: Ridden, road: Road) -> Array:
    """The passive car's record."""
    return ride_peer(of, road.heights, 0, np.zeros(1), road.seed)


def tuned(model: Model, name: str, only: str = "both", budget: int = BUDGET) -> dict[str, float]:
    """Knobs of a peer: the least sum of changes of deflection, comfort and tyre load of `budget` draws.

    only: `iso`, `bumps` or `both`, whose roads count, healthy and with a leak.
    """
    rng = np.random.default_rng([TUNED, PEERS[name].number])
    roads = [iso(model, TUNED + k) for k in range(3)] if only != "bumps" else []
    roads += [bump(model, TUNED + k) for k in range(6)] if only != "iso" else []
    cars = [Ridden(model), Ridden(model, FAULTS["leakage"])]
    bare = [scores(of, roads, passive) for of in cars]
    best, found = math.inf, {}
    for _ in range(budget):
        knobs = {
            k: float(np.exp(rng.uniform(math.log(low), math.log(high))))
            for k, (low, high) in PEERS[name].knobs.items()
        }
        try:
            rider = peer(model, name, knobs)
        except ErError:
            continue
        shares = [scores(of, roads, rider) / b - 1.0 for of, b in zip(cars, bare, strict=True)]
        score = float(np.mean(shares, axis=(0, 1))[:3].sum())
        if score < best:
            best, found = score, knobs
    return found


class Line(NamedTuple):
    """Mean changes (4,) of a controller on roads of a kind with a fault."""

    kind: str
    fault: str
    name: str
    change: Array


def contest(
    riders: Mapping[str, Rider], kinds: Mapping[str, tuple[Sequence[Road], Sequence[Ridden]]],
    names: Mapping[Factors, str], tick: Callable[[int, int], None] | None = None,
) -> list[Line]:  # fmt: skip
    """Every rider on every kind of road and car."""
    jobs = [(kind, roads, of) for kind, (roads, cars) in kinds.items() for of in cars]
    lines = []
    for done, (kind, roads, of) in enumerate(jobs, 1):
        bare = scores(of, roads, passive)
        for name, rider in riders.items():
            mean = (scores(of, roads, rider) / bare - 1.0).mean(axis=0)
            lines.append(Line(kind, names[of.left], name, mean))
        if tick is not None:
            tick(done, len(jobs))
    return lines


def dominated_by(lines: Sequence[Line], one: Line) -> list[str]:
    """Controllers that are better than one in deflection, comfort and tyre load at once."""
    rivals = [
        o for o in lines if (o.kind, o.fault) == (one.kind, one.fault) and o.name != one.name
    ]
    return [o.name for o in rivals if bool(np.all(o.change[:3] <= one.change[:3]))]


def markdown(lines: Sequence[Line]) -> str:
    """The lines as a table, in per cent."""
    rows = [
        "| roads | fault | controller | " + " | ".join(HEADS) + " | dominated by |",
        "|---" * 8 + "|",
    ]
    for line in lines:
        cells = " | ".join(f"{100.0 * v:+.1f}" for v in line.change)
        names = dominated_by(lines, line)
        worse = ", ".join(names) if len(names) < 4 else f"{len(names)} others"
        rows.append(f"| {line.kind} | {line.fault} | {line.name} | {cells} | {worse or '-'} |")
    return "\n".join(rows)


def tones_markdown(rows: Mapping[float, Array]) -> str:
    """Changes (4,) at each frequency [Hz] as a table, in per cent."""
    lines = ["| tone [Hz] | " + " | ".join(HEADS) + " |", "|---" * 5 + "|"]
    for hertz, row in rows.items():
        lines.append(f"| {hertz:g} | " + " | ".join(f"{100.0 * v:+.1f}" for v in row) + " |")
    return "\n".join(lines)


def limited(cars: Sequence[Ridden], u_max: float, latency: int) -> list[Ridden]:
    """The cars within the limits of a rig."""
    return [replace(of, u_max=u_max, latency=latency) for of in cars]
