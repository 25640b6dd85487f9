"""Which pieces, together, separate best: every motion and duty of the menu, then what is near the best."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from er_model_lab.diagnosis.rule import RULE
from er_model_lab.plan import motions_and_duties
from er_model_lab.plan.piece import Bench, Tried, broad, judged, score, separations
from er_model_lab.plan.segment import Segment

MOST_PIECES = 3
MOTIONS_KEPT = 5
"""Motions for which every duty is tried."""
TYPICAL = (0, 2, 5)
"""Places of the duties that every motion is tried with: none, stairs, a square wave."""
SWEEPS = 2
"""How often the neighbours of the best pieces are tried."""


def typical(bench: Bench) -> list[Tried]:
    """All motions of the menu with the typical duties."""
    found = []
    for motion in motions_and_duties.motions(bench.limits):
        kinds = list(motions_and_duties.duties(bench.limits, motion))
        found += _judged((replace(motion, duty=kinds[k]) for k in TYPICAL), bench)
    return found


def tried_menu(bench: Bench) -> list[Tried]:
    """All motions with the typical duties, then the most telling motions with all duties."""
    found = typical(bench)
    for motion in _most_telling(found, tuple(bench.rivals.mimics)):
        kinds = list(motions_and_duties.duties(bench.limits, motion))
        more = (replace(motion, duty=k) for i, k in enumerate(kinds) if i not in TYPICAL)
        found += _judged(more, bench)
    return found


def _most_telling(pieces: Sequence[Tried], names: Sequence[str]) -> list[Segment]:
    """For each truth the motions whose best piece separates most."""
    kept: list[Segment] = []
    for name in names:
        best: list[Segment] = []
        for piece in sorted(pieces, key=lambda p: -separations([p])[name]):
            motion = piece.segment
            if not any(_same_motion(motion, m) for m in best) and len(best) < MOTIONS_KEPT:
                best.append(motion)
        kept += [m for m in best if not any(_same_motion(m, k) for k in kept)]
    return kept


def _same_motion(one: Segment, other: Segment) -> bool:
    """Whether two pieces differ in their duty only."""
    return one.road == other.road and one.level == other.level


def directions(pieces: Sequence[Tried]) -> tuple[str, ...]:
    """The truths that some piece tells from the other explanation; all where none does.

    A special case of another effect is always imitated: nothing is to be gained by asking for it.
    """
    names = tuple(pieces[0].parts)
    best = {n: max(separations([p])[n] for p in pieces) for n in names}
    seen = tuple(n for n in names if best[n] >= RULE.smallest)
    return seen or names


def best_sets(
    pieces: Sequence[Tried], directions: Sequence[str], most: int, longest: float
) -> list[tuple[Tried, ...]]:
    """The most separating programs of a few pieces, best first, broad enough for the lab; longest: of them all [s]."""
    pieces = [p for p in pieces if p.segment.seconds <= longest]
    pool = sorted(pieces, key=lambda p: -score([p], directions))[: 3 * most]
    for name in directions:
        pool += sorted(pieces, key=lambda p: -separations([p])[name])[:most]
    found = []
    for seed in dict.fromkeys(pool):
        grown = _grown((seed,), pool, directions, longest)
        chosen = _broadened(grown, pieces, directions, longest)
        if chosen is not None:
            found.append(chosen)
    found.sort(key=lambda c: -score(c, directions))
    return _different(found)[:most]


def _fits(chosen: Sequence[Tried], longest: float) -> bool:
    """Whether pieces are no longer together than allowed [s]: what does not run tells nothing."""
    return sum(p.segment.seconds for p in chosen) <= longest


def _grown(
    chosen: tuple[Tried, ...], pool: Sequence[Tried], directions: Sequence[str], longest: float
) -> tuple[Tried, ...]:
    """Pieces added while they raise the score, and fit."""
    while len(chosen) < MOST_PIECES:
        options = [(*chosen, p) for p in pool if p not in chosen and _fits((*chosen, p), longest)]
        if not options:
            break
        more = max(options, key=lambda c: score(c, directions))
        if score(more, directions) <= 1.02 * score(chosen, directions):
            break
        chosen = more
    return chosen


def _broadened(
    chosen: tuple[Tried, ...], pieces: Sequence[Tried], directions: Sequence[str], longest: float
) -> tuple[Tried, ...] | None:
    """The pieces with one more where their motion is a single tone; None if none would do.

    Where there is no time for one more, the last piece makes room.
    """
    if broad(chosen):
        return chosen
    for kept in (chosen, chosen[:-1]):
        options = [(*kept, p) for p in pieces if broad((*kept, p)) and _fits((*kept, p), longest)]
        if options:
            return max(options, key=lambda c: score(c, directions))
    return None


def refined(
    chosen: tuple[Tried, ...], bench: Bench, directions: Sequence[str]
) -> tuple[Tried, ...]:
    """The pieces replaced by neighbours as long as that separates better."""
    for _ in range(SWEEPS):
        before = score(chosen, directions)
        for place in range(len(chosen)):
            options = motions_and_duties.variants(chosen[place].segment, bench.limits)
            for other in _judged(options, bench):
                trial = (*chosen[:place], other, *chosen[place + 1 :])
                new = all(p.segment != other.segment for p in chosen)
                able = new and broad(trial) and _fits(trial, bench.limits.duration)
                if able and score(trial, directions) > score(chosen, directions):
                    chosen = trial
        if score(chosen, directions) < 1.02 * before:
            break
    return chosen


def _judged(segments: Iterable[Segment], bench: Bench) -> list[Tried]:
    """The pieces that can be run."""
    found = bench.work.map(judged, list(segments), bench, stage="pieces of a program")
    return [piece for piece in found if piece is not None]


def _different(sets: Sequence[tuple[Tried, ...]]) -> list[tuple[Tried, ...]]:
    """Sets whose pieces differ in more than the order."""
    seen, out = set[frozenset[int]](), []
    for chosen in sets:
        key = frozenset(id(p) for p in chosen)
        if key not in seen:
            seen.add(key)
            out.append(chosen)
    return out
