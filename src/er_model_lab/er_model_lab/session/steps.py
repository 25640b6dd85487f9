"""What a user does in a session, as values: steps that can be taken back, saved, and written as a program."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from er_models.errors import InputError
from er_models.model import Model
from er_records.dataset import Dataset
from er_records.record import Record

SHORTEST = 1.0
"""Shortest piece of a record that is held out, or left to learn from [s]."""


@dataclass(frozen=True)
class Source:
    """A file or folder of measurements, and what its columns are where the user said so (`load(names=...)`)."""

    path: Path
    names: Mapping[str, Any] | None = None


@dataclass(frozen=True)
class Stretch:
    """What is held out of a record, from `start` to `end` after its first sample [s]."""

    record: int
    start: float = 0.0
    end: float = math.inf


@dataclass(frozen=True)
class Step:
    """What was done: its kind, the effect, model or file concerned, and the values that belong to it.

    kind: open, data, hold, start, new, set, off, on, fitted, add, back, improve.
    """

    kind: str
    what: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def fits(self) -> bool:
        """Whether it refitted the model."""
        return self.kind in ("add", "back", "improve")

    @property
    def moved(self) -> tuple[str, str]:
        """Effect and parameter of one that was set."""
        return self.what, str(self.values.get("parameter", ""))

    @property
    def says(self) -> str:
        """What was done, in a few words."""
        words = {
            "open": "session opened", "data": "data", "hold": "held out", "start": "model", "new": "new model",
            "set": "set", "off": "without", "back": "taken back:",
            "on": "again with", "fitted": "back to the fitted values of", "add": "added", "improve": "improved",
        }[self.kind]  # fmt: skip
        return f"{words} {self.what.replace('_', ' ')}".rstrip()


@dataclass(frozen=True)
class State:
    """A moment of a session.

    fitted: the model as it was last given or fitted, to which values go back; off: values of effects that are switched
    off; step: what led here.
    """

    step: Step = Step("open")
    sources: tuple[Source, ...] = ()
    held: tuple[Stretch, ...] = ()
    model: Model | None = None
    fitted: Model | None = None
    off: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    @property
    def known(self) -> Model:
        """The model; `InputError` while there is none."""
        if self.model is None:
            raise InputError("model", "", "a model to begin with", "none")
        return self.model

    def with_data(self, sources: Sequence[Source]) -> State:
        """Other data, of which nothing is held out by hand."""
        return replace(
            self, sources=tuple(sources), held=(),
            step=Step("data", ", ".join(s.path.name for s in sources)),
        )  # fmt: skip

    def with_held(self, held: Sequence[Stretch], records: Sequence[Record]) -> State:
        """Other stretches of the records held out; the step names the rows.

        Raises:
            InputError: Nothing would be left to learn from.
        """
        learn, score = pieces(records, held)
        what = f"{len(held)} stretch{'es' * (len(held) > 1)}" if held else "nothing by hand"
        return replace(
            self, held=tuple(held), step=Step("hold", what, {"learn": learn, "score": score})
        )

    def started(self, model: Model, origin: str, code: Sequence[Path] = ()) -> State:
        """Another model to begin with; origin: its name, or its file; code: files with the effects that it may have."""
        own = {"effects_from": [str(path) for path in code]} if code else {}
        return self._begun(model, Step("start", model.name, {"from": origin, **own}))

    def scaled(self, model: Model, kind: str) -> State:
        """A start model of a kind that was scaled to the data."""
        return self._begun(model, Step("new", model.name, {"kind": kind}))

    def _begun(self, model: Model, step: Step) -> State:
        return replace(self, model=model, fitted=model, off={}, step=step)

    def set(self, effect: str, parameter: str, value: float) -> State:
        """One parameter moved [SI].

        Raises:
            InputError: A value beyond the bounds, or none.
        """
        model = self.known
        low, high = model.bounds(effect, parameter)
        if not low <= value <= high:
            raise InputError(
                model.name,
                f"{effect}.{parameter}",
                f"a number from {low:.4g} to {high:.4g}",
                value,
            )
        moved = model.with_effect(effect, {**model.effects[effect], parameter: value})
        step = Step("set", effect, {"parameter": parameter, **moved.effects[effect]})
        return replace(self, model=moved, step=step)

    def switched(self, effect: str, *, on: bool) -> State:
        """An effect switched off, or on again with the values that it had."""
        model = self.known
        if on == (effect in model.effects):
            return self
        if not on:
            off = {**self.off, effect: dict(model.effects[effect])}
            return replace(
                self, model=model.without_effect(effect), off=off, step=Step("off", effect)
            )
        if effect not in self.off:
            raise InputError(model.name, effect, "an effect that was switched off", "none; add it")
        values = self.off[effect]
        off = {name: v for name, v in self.off.items() if name != effect}
        return replace(
            self, model=model.with_effect(effect, values), off=off, step=Step("on", effect, values)
        )

    def as_fitted(self) -> State:
        """Every effect and value as it was given or fitted."""
        return replace(self, model=self.fitted, off={}, step=Step("fitted", self.known.name))

    def learnt(self, model: Model, step: Step) -> State:
        """What a fit made."""
        return replace(self, model=model, fitted=model, off={}, step=step)


def files_of(session: Session) -> tuple[Path, ...]:
    """Every file that a session names: measurements, models, and Python files with effects."""
    data = [s.path for state in session.past for s in state.sources]
    starts = [dict(s.step.values) for s in session.past if s.step.kind == "start"]
    models = [Path(str(values["from"])) for values in starts]
    code = [Path(path) for values in starts for path in values.get("effects_from", ())]
    return tuple(dict.fromkeys([*data, *(m for m in models if m.suffix), *code]))


@dataclass(frozen=True)
class Session:
    """States up to now, and those that were taken back; seed: of everything random."""

    past: tuple[State, ...] = (State(),)
    future: tuple[State, ...] = ()
    seed: int = 0

    @property
    def now(self) -> State:
        """Where the session is."""
        return self.past[-1]

    @property
    def code(self) -> tuple[Path, ...]:
        """Python files with the effects that its model may have."""
        starts = [s.step.values for s in self.past if s.step.kind == "start"]
        return tuple(Path(path) for path in starts[-1].get("effects_from", ())) if starts else ()

    def then(self, state: State) -> Session:
        """One step further; a parameter that is dragged is one step."""
        if state is self.now:
            return self
        new, last = state.step, self.now.step
        dragged = new.kind == last.kind == "set" and new.moved == last.moved
        return replace(self, past=(*self.past[: -1 if dragged else None], state), future=())

    def undone(self) -> Session:
        """One step back; the same where there is none."""
        return self.at(len(self.past) - 2) if len(self.past) > 1 else self

    def redone(self) -> Session:
        """One step forward; the same where there is none."""
        return self.at(len(self.past)) if self.future else self

    def at(self, number: int) -> Session:
        """At any of all steps, with those behind it taken back."""
        every = (*self.past, *self.future)
        number = min(max(number, 0), len(every) - 1)
        return replace(self, past=every[: number + 1], future=every[number + 1 :])


def joined(held: Sequence[Stretch]) -> tuple[Stretch, ...]:
    """Stretches by record and time, those that touch as one."""
    out = list[Stretch]()
    for s in sorted(held, key=lambda s: (s.record, s.start)):
        if out and out[-1].record == s.record and s.start <= out[-1].end:
            out[-1] = replace(s, start=out[-1].start, end=max(s.end, out[-1].end))
        else:
            out.append(s)
    return tuple(out)


Piece = tuple[int, int, int] | tuple[int]
"""Which record, and its rows from and to where it is not the whole."""


def pieces(records: Sequence[Record], held: Sequence[Stretch]) -> tuple[list[Piece], list[Piece]]:
    """What of the records is learnt from, and what only scores; what would be too short belongs to neither.

    Raises:
        InputError: Nothing is left to learn from.
    """
    learn, score = list[Piece](), list[Piece]()
    for k, record in enumerate(records):
        out, since = np.zeros(len(record), bool), record.t - record.t[0]
        for s in held:
            out |= (since >= s.start) & (since <= s.end) & (s.record == k)
        edges = [0, *(np.flatnonzero(np.diff(out)) + 1).tolist(), len(record)]
        for i, j in pairwise(edges):
            if len(edges) == 2 or (j - i) * record.dt >= SHORTEST:
                (score if out[i] else learn).append((k, i, j) if len(edges) > 2 else (k,))
    if not learn:
        raise InputError("held_out", "", f"at least {SHORTEST:g} s left to learn from", "none")
    return learn, score


def divided(records: Sequence[Record], held: Sequence[Stretch]) -> Dataset:
    """The records as a data set in which the stretches only score; as `pieces`, whose error it raises."""

    def cut(piece: Piece) -> Record:
        record = records[piece[0]]
        return record if len(piece) == 1 else record.slice(piece[1], piece[2])

    learn, score = pieces(records, held)
    return Dataset.of(map(cut, learn), map(cut, score))
