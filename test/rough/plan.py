"""Which cases belong to a seed: 150, each a function of its seed and key alone."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from test.rough.rig import DEVICES
from test.rough.truths import TRUTHS

Kind = Literal["complete", "single", "twin", "pair", "poor"]
KINDS: tuple[Kind, ...] = get_args(Kind)
COUNT = {"complete": 30, "single": 70, "twin": 30, "pair": 10, "poor": 10}


@dataclass(frozen=True)
class Twin:
    """One of the kinds that a lab was seen to fail at, in two sizes; what is not given is drawn."""

    device: str
    truths: tuple[str, ...]
    rest: bool = False
    motion: str = ""
    sensors: str = ""
    rate: float = 0.0
    bent: bool = False
    wild: str = ""
    target: float = 0.0


TWINS = {
    "dahl_from_rest": Twin("passive", ("dahl",), rest=True),
    "maxwell_in_motion": Twin("passive", ("maxwell",), motion="noise"),
    "brake_with_play": Twin("brake", ("brake_play",), rest=True, motion="earthquake"),
    "encoder_drive": Twin("brake", ("stribeck",), motion="moves", sensors="encoder", rate=1000.0),
    "bent_drive": Twin(
        "brake", ("stribeck",), motion="moves", sensors="encoder", rate=1000.0, bent=True
    ),
    "knee_valves": Twin("passive", ("knee",), motion="handling", sensors="no_accelerations"),
    "remanence": Twin("mr", ("remanent",)),
    "pressure": Twin("pneumatic", ("pressed",)),
    "outliers": Twin("er", ("coulomb",), wild="outliers"),
    "preload": Twin("passive", ("offset",), target=3.0),
    "one_tone": Twin("er", ("coulomb",), motion="tone"),
    "complete_from_rest": Twin("brake", (), rest=True),
    "warming": Twin("passive", ("heat",)),
    "fading": Twin("er", ("fade",)),
    "three": Twin("mr", ("coulomb", "orifice", "gas")),
}
SIZES = {"small": (40.0, 400.0), "large": (2e3, 20e3)}
"""Ranges of the peak force of the twins [N]."""


@dataclass(frozen=True)
class Asked:
    """One case: its kind, device, what is hidden, its seed and number, the twin and its size where it is one."""

    kind: Kind
    device: str
    truths: tuple[str, ...]
    seed: int
    number: int
    twin: str = ""
    size: str = ""

    @property
    def key(self) -> str:
        """What tells this case from any other."""
        what = f"{self.twin}-{self.size}" if self.twin else "+".join(self.truths) or "nothing"
        return f"{self.kind}/{self.device}/{what}/{self.seed}/{self.number}"

    @property
    def stream(self) -> tuple[int, int]:
        """Start of its random numbers."""
        return self.seed, zlib.crc32(self.key.encode())

    @property
    def like(self) -> Twin:
        """What is given of it, the rest being drawn."""
        return TWINS[self.twin] if self.twin else Twin(self.device, self.truths)


def combinations() -> list[tuple[str, str]]:
    """Every device with every truth that it may have."""
    return [(device, t.name) for t in TRUTHS.values() for device in t.devices]


def _pair(rng: np.random.Generator) -> tuple[str, tuple[str, ...]]:
    """A device with two different truths."""
    device = str(rng.choice(DEVICES))
    able = [
        t
        for d, t in combinations()
        if d == device and t not in ("brake_play", "cogging", "loaded")
    ]
    apart = {"mount", "play", "void"}  # each needs the balance of forces for itself
    while True:
        two = tuple(str(t) for t in rng.choice(able, 2, replace=False))
        if len(apart.intersection(two)) < 2:
            return device, two


def of_seed(seed: int) -> list[Asked]:
    """The 150 cases, mixed, so that the first of them are of all kinds."""
    rng = np.random.default_rng([seed, 0xC0])
    able = combinations()
    cases: list[Asked] = []
    for k in range(COUNT["complete"]):
        cases.append(Asked("complete", DEVICES[k % len(DEVICES)], (), seed, k))
    for k, i in enumerate(_chosen(rng, len(able), COUNT["single"])):
        cases.append(Asked("single", able[i][0], (able[i][1],), seed, k))
    for twin, like in TWINS.items():
        for k, size in enumerate(SIZES):
            cases.append(Asked("twin", like.device, like.truths, seed, k, twin, size))
    for k in range(COUNT["pair"]):
        device, two = _pair(rng)
        cases.append(Asked("pair", device, two, seed, k))
    for k, i in enumerate(_chosen(rng, len(able), COUNT["poor"])):
        cases.append(Asked("poor", able[i][0], (able[i][1],), seed, k))
    return [cases[int(i)] for i in rng.permutation(len(cases))]


def _chosen(rng: np.random.Generator, n: int, count: int) -> list[int]:
    """So many of n, none twice while there are others."""
    rounds = -(-count // n)
    return [int(i) for _ in range(rounds) for i in rng.permutation(n)][:count]


def plan(
    kinds: Sequence[str], seeds: Sequence[int], cases: int | None = None, match: str = ""
) -> list[Asked]:
    """Cases of these kinds, the first so many of each seed; match: only keys that hold this text."""
    out: list[Asked] = []
    for seed in seeds:
        able = [a for a in of_seed(seed) if a.kind in kinds and match in a.key]
        out += able[:cases]
    return out
