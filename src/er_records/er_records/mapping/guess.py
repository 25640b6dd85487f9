"""Which column is which channel: by names and units first, then by what physics says of the samples."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from er_models.errors import InputError

from er_records.mapping import physics
from er_records.mapping.survey import Seen, Survey
from er_records.mapping.words import WORDS, counts_compression, fits
from er_records.readers.names import TIME, Source
from er_records.readers.units import UNITS, field_unit, known_unit, unit_in_name
from er_records.record import Array, unit_of

SURE, LIKELY = 0.85, 0.5
"""From which on a guess is called sure, and from which on it is written."""
PHYSICS, AGAINST = 0.1, -0.25
"""What a relation to other columns adds where it holds, and where it contradicts."""
LARGEST = {"deflection": 1.0, "deflection_velocity": 20.0, "damper_force": 1e6, "duty": 1.0}
"""Largest believable magnitudes [SI]: beyond them a column without a unit is of another one."""
SMALLER = {"m": "mm", "m/s": "mm/s"}
"""What a motion without a unit is offered in that is too large for SI."""
STEPS = (1e-5, 0.1)
"""Between these a recorder steps [s]: a time without a unit is in the largest one that brings it there."""
VOLTAGE = 0.02
"""What a current is preferred by to a voltage."""
CONTRACT = "the name of docs/data.md"
"""Why a column is sure whose name is the channel's own: without a unit it is SI."""
NOISY = 0.02
"""Share by which noise may lift the largest current above a full scale of two digits."""
HELD, EXACT = 0.01, 1e-4
"""Share of samples that are the largest one, and how exactly, where no noise lifts it."""
SNAP = 0.04
"""Share by which a factor that physics finds may miss a unit's."""


@dataclass(frozen=True)
class Guess:
    """A channel's column as `names.yaml` says it, how sure that is (0 to 1), and why."""

    channel: str
    seen: Seen
    source: Source
    sure: float
    why: tuple[str, ...] = ()

    def more(self, sure: float, why: str, **change: Any) -> Guess:
        """The same, surer or less so, for a further reason; change: of the source."""
        return replace(
            self, source=replace(self.source, **change), sure=min(max(self.sure + sure, 0.0), 0.99),
            why=(*self.why, why),
        )  # fmt: skip

    @property
    def unit(self) -> str:
        """The unit that counts; '' where none is known."""
        return self.source.unit or self.seen.unit

    @property
    def offer(self) -> str:
        """The column as a user may say it, with the unit that it must be in where it states none."""
        unit = SMALLER.get(si_of(self.channel), "") if not self.unit and self.too_large else ""
        return f"{self.seen.header} [{unit}]" if unit else self.seen.header

    @property
    def too_large(self) -> bool:
        """Whether what the column holds cannot be in SI units."""
        return max(abs(self.seen.low), abs(self.seen.high)) > LARGEST.get(self.channel, math.inf)

    @property
    def factor(self) -> float | None:
        """Factor to SI; None where no unit is known."""
        known = known_unit(si_of(self.channel), self.unit) if self.unit else None
        return UNITS[si_of(self.channel)][known] if known else None


def si_of(channel: str) -> str:
    """SI unit of a channel or the time."""
    return "s" if channel == TIME else unit_of(channel) or "1"


def guessed(survey: Survey, given: Mapping[str, Source] | None = None) -> dict[str, Guess]:
    """Channels with their columns, those that the user gives among them.

    given: what the user says: literal where it has a sign, scale or offset; else unit, sign and full scale are looked
    for as for any guess. A source without column, rate and value takes a channel away.

    Raises:
        InputError: A column that is not there.
    """
    given = dict(given or {})
    found = {c: _told(survey, c, s) for c, s in given.items() if s.column}
    taken = {g.seen.name for g in found.values()}
    free = [s for s in survey.columns if s.name not in taken]
    found |= _by_words(free, given.keys() | found.keys())
    found = {c: g if c in _literal(given) else _by_its_name(g) for c, g in found.items()}
    timed = _timed(survey, found, given)
    found = {c: g for c, g in timed.items() if c not in given or given[c].column}
    return {c: _finished(g) for c, g in _related(survey, found, given).items()}


def _told(survey: Survey, channel: str, source: Source) -> Guess:
    """A column that the user names, by its whole header or its name."""
    for seen in survey.columns:
        bare = source.column.strip()
        if bare in (seen.header, seen.name) or bare.split(" [")[0] == seen.name:
            stated = bare[len(seen.name) :].strip(" []()") if bare != seen.header else ""
            unit = source.unit or ("" if stated == seen.unit else stated)
            own = replace(source, column=seen.header, unit=unit)
            return Guess(channel, seen, own, 0.99, ("as told",))
    there = ", ".join(s.header for s in survey.columns[:12])
    raise InputError(survey.path, f"column for '{channel}'", f"'{source.column}'", there)


def _by_words(free: list[Seen], taken: Any) -> dict[str, Guess]:
    """The best fitting column of each channel by name and unit, best fit first."""
    scored = [
        (_fit(channel, seen), channel, seen)
        for channel in WORDS if channel not in taken for seen in free
        if channel != TIME or physics.is_time(seen.samples)
    ]  # fmt: skip
    found: dict[str, Guess] = {}
    used: set[str] = set()
    for score, channel, seen in sorted(scored, key=lambda each: -each[0]):
        if score < 0.2 or channel in found or seen.name in used:
            continue
        said = (
            "name and unit" if score > 0.8 else "unit" if score <= 0.45 and seen.unit else "name"
        )
        why = CONTRACT if seen.name == channel else said
        found[channel] = Guess(channel, seen, Source(seen.header), score, (why,))
        used.add(seen.name)  # another format may spell it with another unit
    return found


def _fit(channel: str, seen: Seen) -> float:
    """How well a column fits a channel by name and unit; surest where the name is the channel's own."""
    unit = seen.unit or unit_in_name(si_of(channel), seen.name)
    score = fits(channel, seen.name, unit) - VOLTAGE * unit.endswith("V")
    return 0.95 if seen.name == channel and score > 0.0 else score


def _by_its_name(guess: Guess) -> Guess:
    """A guess without a unit, with the one that its name ends with."""
    unit = "" if guess.unit else unit_in_name(si_of(guess.channel), guess.seen.name)
    return guess.more(0.0, f"in {unit} by its name", unit=unit) if unit else guess


def _timed(
    survey: Survey, found: dict[str, Guess], given: Mapping[str, Source]
) -> dict[str, Guess]:
    """The guesses with a time: a column that rises steadily, unless channels have their own."""
    own = any(s.times is not None for s in survey.columns)
    if TIME in given or own:
        return {c: g for c, g in found.items() if c != TIME or (TIME in given)}
    rising = [s for s in survey.columns if physics.is_time(s.samples)]
    if TIME in found:
        return found | {TIME: _by_its_steps(found[TIME].more(PHYSICS, "rises steadily"))}
    used = {g.seen.name for g in found.values()}
    free = [s for s in rising if s.name not in used]
    if free:
        counts = np.array_equal(np.unique(np.diff(free[0].samples)), [1.0])
        why = ("rises steadily", *["but may count rows"] * counts)
        sure = LIKELY - 0.2 * counts
        found = found | {
            TIME: _by_its_steps(Guess(TIME, free[0], Source(free[0].header), sure, why))
        }
    return found


def _by_its_steps(guess: Guess) -> Guess:
    """A time without a unit, in the one that a recorder's steps are of."""
    step = float(np.median(np.diff(guess.seen.samples)))
    low, high = STEPS
    if guess.unit or step <= high:
        return guess
    unit = next((u for u in ("ms", "us", "ns") if low <= step * UNITS["s"][u] <= high), "")
    why = f"in {unit}: as seconds it would step by {step:.3g} s"
    return guess.more(0.0, why, unit=unit) if unit else guess


def time_of(found: Mapping[str, Guess], given: Mapping[str, Source], seen: Seen) -> Array:
    """Times (n,) [s] of a column, by the guessed time, its own axis or the given rate; else its numbers."""
    if seen.times is not None:
        return seen.times
    guess = found.get(TIME)
    if guess is not None and guess.seen.samples.size == seen.samples.size:
        return np.asarray(guess.seen.samples * (guess.factor or 1.0))
    rate = (given[TIME].rate if TIME in given else None) or 1.0
    return np.arange(seen.samples.size) / rate


def _related(
    survey: Survey, found: dict[str, Guess], given: Mapping[str, Source]
) -> dict[str, Guess]:
    """The guesses looked at together: derivatives, signs, and columns that only physics tells."""
    motion = found.get("deflection") or found.get("deflection_velocity")
    if motion is None:
        found, motion = _by_derivative(survey, found, given)
    if motion is None:
        return found
    t = time_of(found, given, motion.seen)
    if t.size < 10 or np.any(np.diff(t) <= 0.0):
        return found
    same = [s for s in survey.columns if s.samples.size == t.size]
    found = _with_velocity(found, same, t, given)
    found = _with_direction(found, given)
    v = _velocity(found, t)
    found = _with_force(found, same, v, given)
    used = {g.seen.name for g in found.values()}
    switched = [
        s for s in same
        if s.name not in used and physics.is_switched(s.samples) and not physics.is_time(s.samples)
    ]  # fmt: skip
    if "duty" not in found and "duty" not in given and switched:
        why = ("holds a few values, as a duty does",)
        found = found | {"duty": Guess("duty", switched[0], Source(switched[0].header), 0.4, why)}
    return found


def _by_derivative(
    survey: Survey, found: dict[str, Guess], given: Mapping[str, Source]
) -> tuple[dict[str, Guess], Guess | None]:
    """Deflection and velocity as the two free columns of which one is the derivative of the other."""
    used = {g.seen.name for g in found.values()}
    free = [s for s in survey.columns if s.name not in used and s.high > s.low]
    for of in free:
        t = time_of(found, given, of)
        others = [s for s in free if s is not of and s.samples.size == of.samples.size == t.size]
        for is_ in others:
            if np.all(np.diff(t) > 0.0) and physics.derivative(of.samples, is_.samples, t).holds:
                why = (f"'{is_.name}' is its derivative",)
                motion = Guess("deflection", of, Source(of.header), LIKELY, why)
                return found | {"deflection": motion}, motion
    return found, None


def _with_velocity(
    found: dict[str, Guess], same: list[Seen], t: Array, given: Mapping[str, Source]
) -> dict[str, Guess]:
    """The velocity found or confirmed as the derivative of the deflection, with unit and sign."""
    x = found.get("deflection")
    if x is None or x.seen.samples.size != t.size:
        return found
    used = {g.seen.name for g in found.values()}
    guess = found.get("deflection_velocity")
    if "deflection_velocity" not in given and not _derived(x, guess, t):
        each = {
            s.header: (physics.derivative(x.seen.samples, s.samples, t), s)
            for s in same
            if s.name not in used
        }
        best = max(each.values(), key=lambda d: abs(d[0].correlation), default=None)
        if best is not None and best[0].holds:
            found = {c: g for c, g in found.items() if g.seen.header != best[1].header}
            guess = Guess("deflection_velocity", best[1], Source(best[1].header), LIKELY)
    if guess is None or guess.seen.samples.size != t.size:
        return found
    relation = physics.derivative(x.seen.samples, guess.seen.samples, t)
    if not relation.holds:
        doubt = f"is no derivative of '{x.seen.name}'"
        return found | {"deflection_velocity": guess.more(AGAINST, doubt)}
    guess = guess.more(PHYSICS, f"is the derivative of '{x.seen.name}'")
    x = x.more(PHYSICS, f"'{guess.seen.name}' is its derivative")
    gain = abs(relation.gain)
    x = _unit_by(x, guess.factor and guess.factor * gain)
    guess = _unit_by(guess, x.factor and x.factor / gain)
    if relation.gain < 0.0 and "deflection_velocity" not in _literal(given):
        guess = guess.more(0.0, "turned against the deflection", sign=-1.0)
    return found | {"deflection": x, "deflection_velocity": guess}


def _derived(x: Guess, guess: Guess | None, t: Array) -> bool:
    """Whether a guessed velocity is the derivative of the deflection."""
    if guess is None or guess.seen.samples.size != t.size:
        return guess is not None  # at other times it cannot be told
    return physics.derivative(x.seen.samples, guess.seen.samples, t).holds


def _unit_by(guess: Guess, factor: float | None) -> Guess:
    """A guess without a unit, with the one whose factor physics asks for."""
    if guess.unit or not factor:
        return guess
    table = UNITS[si_of(guess.channel)]
    near = [u for u, f in table.items() if abs(factor / f - 1.0) <= SNAP]
    return guess.more(0.0, f"in {near[0]} by its derivative", unit=near[0]) if near else guess


def _literal(given: Mapping[str, Source]) -> set[str]:
    """Channels of which the user says more than column and unit: nothing is added to it."""
    return {c for c, s in given.items() if s.signed or replace(s, column="", unit="") != Source()}


def _with_direction(found: dict[str, Guess], given: Mapping[str, Source]) -> dict[str, Guess]:
    """Motions whose names count compression, turned."""
    x = found.get("deflection")
    if x is None or "deflection" in _literal(given) or not counts_compression(x.seen.name):
        return found
    found = found | {"deflection": x.more(0.0, "its name counts compression", sign=-1.0)}
    v = found.get("deflection_velocity")
    if v is not None and "deflection_velocity" not in _literal(given):
        found |= {"deflection_velocity": v.more(0.0, "turned with it", sign=-v.source.sign)}
    return found


def _velocity(found: Mapping[str, Guess], t: Array) -> Array:
    """Velocity (n,) with its sign, in any unit, from the deflection, else from its own column."""
    x = found.get("deflection")
    if x is not None and x.seen.samples.size == t.size:
        return x.source.sign * physics.velocity(x.seen.samples, t)
    guess = found["deflection_velocity"]
    return guess.source.sign * physics.smooth(guess.seen.samples)


def _with_force(
    found: dict[str, Guess], same: list[Seen], v: Array, given: Mapping[str, Source]
) -> dict[str, Guess]:
    """The force found or confirmed as what takes energy out of the motion, with its sign."""
    guess = found.get("damper_force")
    if guess is None and "damper_force" not in given:
        used = {g.seen.name for g in found.values()}
        free = {
            s.header: (abs(physics.dissipation(s.samples, v)), s)
            for s in same
            if s.name not in used and s.high > s.low
        }
        best = max(free.values(), key=lambda each: each[0], default=None)
        if best is not None and best[0] > 0.5:
            guess = Guess("damper_force", best[1], Source(best[1].header), 0.4)
    if guess is None or guess.seen.samples.size != v.size:
        return found
    share = physics.dissipation(guess.seen.samples, v)
    if abs(share) < 0.15:
        return found | {
            "damper_force": guess.more(AGAINST / 2, "neither drives nor brakes the motion")
        }
    brakes = "takes energy out of the motion"
    said = brakes if share > 0.0 else f"{brakes} once turned"
    guess = guess.more(PHYSICS, said)
    if share < 0.0 and "damper_force" not in _literal(given):
        guess = replace(guess, source=replace(guess.source, sign=-1.0))
    return found | {"damper_force": guess}


def _finished(guess: Guess) -> Guess:
    """A guess with the full scale of a duty, and less sure where no unit is known or it cannot be SI."""
    high = max(abs(guess.seen.low), abs(guess.seen.high))
    if guess.source.full_scale is not None or guess.source.scale is not None:
        return guess
    if guess.channel == "duty":
        return _with_full_scale(guess, high)
    if guess.unit and guess.factor is None:
        return guess.more(-0.5, f"unknown unit {guess.unit}")
    if not guess.unit and guess.channel != TIME:
        if guess.why[:1] == (CONTRACT,) and not guess.too_large:
            return guess
        if guess.too_large:
            return guess.more(-0.5, "no unit, and too large for SI")
        return guess.more(-0.05, "no unit: taken as SI")
    return guess


def _with_full_scale(guess: Guess, high: float) -> Guess:
    """A current or voltage with the full scale that the largest one gives; a duty as it is."""
    is_share = known_unit("1", guess.unit) is not None if guess.unit else high <= 1.0 + 1e-6
    if is_share and not field_unit(guess.unit):
        return guess
    if high <= 0.0:
        return guess.more(0.0, "zero throughout", full_scale=1.0)
    near = float(f"{high:.2g}")
    if float(np.mean(guess.seen.samples >= (1.0 - EXACT) * high)) > HELD:
        near = float(f"{high:.5g}")
    full = near if abs(high / near - 1.0) <= NOISY else nice(high)
    return guess.more(
        -0.05,
        f"full scale: the largest value there is, {full:g} {guess.unit}".rstrip(),
        full_scale=full,
    )


def nice(value: float) -> float:
    """The number of three digits that is no smaller, but for rounding."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return float(f"{math.ceil(value / step - 1e-6) * step:.6g}")
