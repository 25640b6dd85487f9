"""Which cases are asked: every kind, effect and seed, each a function of its seed alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from test.blind.catalogue import BY_NAME, INSIDE, OUTSIDE
from test.blind.plant import Program
from test.blind.slots import FIXED_ROWS

Kind = Literal["singles", "pairs", "complete", "outside", "degenerate"]
KINDS: tuple[Kind, ...] = get_args(Kind)

PAIRS_A_SEED = 10
COMPLETE_A_SEED = 20
POOR_A_SEED = 2
FEW_SINGLES, FEW_COMPLETE = 6, 2
DRAWN = tuple(e for e in INSIDE if e.slot is not None and e.slot < FIXED_ROWS)
"""Effects that pairs and the like are drawn from: one that came after seeds were scored would change their draws."""
OF_THE_DAMPER = tuple(
    f"outside:{kind}" for kind in ("position_periodic", "x_v_coupling", "stroke_memory", "stick_events")
)  # fmt: skip
"""Outside effects that act whatever the sampling: the others are made of samples at 200 Hz."""
_PAIRS, _POOR, _LAYOUT, _FEW = range(4)


@dataclass(frozen=True)
class Layout:
    """How much is recorded: number of records, and the length of each [s]."""

    records: int
    seconds: float


@dataclass(frozen=True)
class Asked:
    """One case: its kind, what is hidden (empty: nothing), its seed, the program of its inputs, and the bench."""

    kind: Kind
    hidden: tuple[str, ...]
    seed: int
    program: Program = "rich"
    condition: str = ""

    @property
    def key(self) -> str:
        """What tells this case from any other."""
        key = f"{self.kind}/{'+'.join(self.hidden) or 'nothing'}/{self.program}/{self.seed}"
        return f"{self.condition}/{key}" if self.condition else key


def layout(seed: int) -> Layout:
    """One to three records of 40 to 90 s each."""
    rng = np.random.default_rng([seed, _LAYOUT])
    return Layout(int(rng.integers(1, 4)), round(2.0 * rng.uniform(40.0, 90.0)) / 2.0)


def _several(rng: np.random.Generator, count: int) -> tuple[str, ...]:
    """Different effects of the catalogue."""
    return tuple(DRAWN[int(i)].name for i in rng.choice(len(DRAWN), count, replace=False))


def of_kind(kind: Kind, seed: int) -> Iterator[Asked]:
    """Every case of a kind that belongs to a seed."""
    if kind == "singles":
        yield from (Asked(kind, (e.name,), seed) for e in INSIDE)
    elif kind == "outside":
        yield from (Asked(kind, (e.name,), seed) for e in OUTSIDE)
    elif kind == "pairs":
        rng = np.random.default_rng([seed, _PAIRS])
        pairs = {_several(rng, 2): None for _ in range(PAIRS_A_SEED)}
        yield from (Asked(kind, pair, seed) for pair in pairs)
    elif kind == "complete":
        yield from (Asked(kind, (), 100 * seed + i) for i in range(COMPLETE_A_SEED))
    else:
        rng = np.random.default_rng([seed, _POOR])
        programs: tuple[Program, ...] = ("constant_duty", "one_sine")
        for program in programs:
            for _ in range(POOR_A_SEED):
                yield Asked(kind, _several(rng, 1), seed, program)


def plan(
    kinds: Sequence[Kind], seeds: Sequence[int], effects: Sequence[str] | None = None
) -> list[Asked]:
    """All cases asked for, each once, seed by seed so that a run cut short is still balanced.

    effects: only cases that hide one of these; ``none`` for those that hide nothing.
    """
    cases = {a.key: a for seed in seeds for kind in kinds for a in of_kind(kind, seed)}
    if effects is None:
        return list(cases.values())
    return [a for a in cases.values() if set(a.hidden or ("none",)) & set(effects)]


def few(seed: int) -> list[Asked]:
    """Six singles, two complete models and one of outside: the cases of a seed that every condition is asked."""
    rng = np.random.default_rng([seed, _FEW])
    singles = rng.choice(len(DRAWN), FEW_SINGLES, replace=False)
    return [
        *(Asked("singles", (DRAWN[int(i)].name,), seed) for i in singles),
        *(Asked("complete", (), 100 * seed + i) for i in range(FEW_COMPLETE)),
        Asked("outside", (str(rng.choice(OF_THE_DAMPER)),), seed),
    ]


def known(name: str) -> bool:
    """Whether an effect can be asked for."""
    return name == "none" or name in BY_NAME
