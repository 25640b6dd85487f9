"""A folder's mapping as a result: what was found, how sure that is, and the `names.yaml` that says it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from er_models.errors import ErError, InputError, UnknownName

from er_records.load import load
from er_records.mapping import physics
from er_records.mapping.guess import LIKELY, SURE, Guess, guessed, time_of
from er_records.mapping.survey import Seen, Survey, survey
from er_records.readers.names import NOTHING, TIME, Given, Names, Source, parsed
from er_records.record import CHANNELS, Record, unit_of
from er_records.write import finished_only


@dataclass(frozen=True, eq=False)
class Mapped:
    """What `lab map` finds: columns (survey), guesses by channel, and what the user said beside them.

    records: as they read with this mapping; trouble: why they do not, else ''. Neither while nothing but the time is
    known.
    """

    survey: Survey
    guesses: Mapping[str, Guess]
    made: Mapping[str, Source] = field(default_factory=dict)
    records: tuple[Record, ...] = ()
    trouble: str = ""

    @property
    def sources(self) -> dict[str, Source]:
        """Channels with what is sure enough to be written."""
        order = (TIME, *CHANNELS, *sorted(self.guesses.keys() - {TIME, *CHANNELS}))
        sure = {c: self.guesses[c] for c in order if c in self.guesses}
        written = {c: self._written(g) for c, g in sure.items() if g.sure >= LIKELY}
        return written | dict(self.made)

    @property
    def names(self) -> dict[str, Any]:
        """The mapping as `names=` of `load` and a `names.yaml` take it."""
        return {channel: _plain(source) for channel, source in self.sources.items()}

    @property
    def unsure(self) -> dict[str, Guess]:
        """Guesses that are too weak to be written."""
        return {c: g for c, g in self.guesses.items() if g.sure < LIKELY}

    @property
    def hint(self) -> str:
        """How the middle of the stroke becomes the zero of a deflection that never crosses it; '' where it does."""
        x = [r.channels["deflection"] for r in self.records if r.has("deflection")]
        source = self.sources.get("deflection")
        if source is None or not x:
            return ""
        low, high = np.nanpercentile(np.concatenate(x), (0.1, 99.9))
        if low <= 0.0 <= high:
            return ""
        middle = float(f"{0.5 * (low + high):.3g}")
        said = json.dumps(
            _plain(replace(source, offset=source.offset - middle)), ensure_ascii=False
        )
        return (
            f"the deflection is {1e3 * low:.3g} to {1e3 * high:.3g} mm, never zero; with the middle of the stroke as "
            f"zero, for all files of this sensor: --set deflection='{said}'"
        )

    @property
    def needless(self) -> bool:
        """Whether every column has the contract's name and needs no mapping."""
        return all(
            replace(s, column="") == Source() and s.column == c for c, s in self.sources.items()
        )

    def channel_of(self, seen: Seen) -> Guess | None:
        """What a column is taken for."""
        each = list(self.guesses.values())
        own = [g for g in each if g.seen.header == seen.header]
        alike = [g for g in each if g.seen.name == seen.name and not seen.unit]
        return next(iter(own + alike), None)

    def rate_of(self, seen: Seen) -> float:
        """Rate of a column [Hz]; nan where no time is known."""
        if seen.times is None and TIME not in self.guesses and TIME not in self.made:
            return float("nan")
        return physics.rate_of(time_of(self.guesses, self.made, seen))

    def _written(self, guess: Guess) -> Source:
        """A source as it is written: by the bare name, so that the unit of each file counts, where that is clear.

        Where some files state the unit of a name and others none, the one that is stated counts for all.
        """
        seen, named = guess.seen, [s for s in self.survey.columns if s.name == guess.seen.name]
        if len([s for s in named if s.file == seen.file]) > 1:
            return replace(guess.source, column=seen.header)
        units = {s.unit for s in named}
        stated = guess.source.unit or (
            "".join(units - {""}) if "" in units and len(units) == 2 else ""
        )
        return replace(guess.source, column=seen.name, unit=stated)

    def text(self) -> str:
        """The `names.yaml`, each line with how sure it is and why."""
        lines = [
            "# What the columns of these files are: ./er lab map wrote it, docs/data.md explains it."
        ]
        for channel, entry in self.names.items():
            written = yaml.safe_dump(
                entry, default_flow_style=True, allow_unicode=True, width=1000, sort_keys=False
            )
            guess = self.guesses.get(channel)
            why = f"  # {guess.sure:.0%}: {', '.join(guess.why)}" if guess else ""
            lines.append(
                f"{channel}: {written.removesuffix(chr(10)).removesuffix(chr(10) + '...')}{why}"
            )
        return "\n".join(lines) + "\n"

    def save(self, path: Path | None = None, *, replaced: bool = False) -> Path:
        """Write the mapping, as a rule into the folder of the data.

        Raises:
            InputError: There is one already, and nobody said that it may be replaced.
        """
        path = path or self.survey.names_file
        if path.exists() and not replaced:
            expected = "no mapping yet, or --replace"
            raise InputError(path, "", expected, "one that is there already")
        with finished_only(path) as part:
            part.write_text(self.text(), encoding="utf-8")
        return path

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        columns = []
        for seen in self.survey.columns:
            guess, rate = self.channel_of(seen), self.rate_of(seen)
            columns.append({
                "column": seen.name, "unit": seen.unit, "low": seen.low, "high": seen.high,
                "rate": rate if np.isfinite(rate) else None, "channel": guess.channel if guess else None,
                "sure": round(guess.sure, 3) if guess else None, "why": list(guess.why) if guess else [],
            })  # fmt: skip
        return {
            "command": "map", "files": [str(f) for f in self.survey.files], "columns": columns, "names": self.names,
            "unsure": sorted(self.unsure), "records": [r.name for r in self.records], "trouble": self.trouble,
            "notes": list(dict.fromkeys(n for r in self.records for n in r.notes)), "hint": self.hint,
        }  # fmt: skip


def _plain(source: Source) -> Any:
    """A source as a user writes it."""
    said = {
        f.name: getattr(source, f.name) for f in fields(Source) if f.compare and f.name != "column"
    }
    entry = {k: v for k, v in said.items() if v != getattr(NOTHING, k)}
    entry = {k: int(v) if k == "sign" else v for k, v in entry.items()}
    if source.value is not None:
        entry["value"] = list(source.value) if len(source.value) > 1 else source.value[0]
    if not entry:
        return source.column
    return ({"from": source.column} if source.column else {}) | entry


def mapped(path: str | Path, names: Mapping[str, Any] | None = None) -> Mapped:
    """What the columns of a file or folder are, guessed by name, unit and physics, and the mapping that says it.

    Nothing is written; `save` does that. names: what is known already, such as `{"damper_force": "Kraft [kN]"}`;
    what it leaves open (sign, full scale, unit) is looked for. A channel of None is left out.

    Raises:
        InputError: No measurement, or a column in names that is not there.
    """
    seen = survey(Path(path))
    given = said(names or {})
    guesses = guessed(seen, given)
    made = {c: s for c, s in given.items() if not s.column and (s.rate or s.value is not None)}
    found = Mapped(seen, guesses, made)
    try:
        own = Names(found.sources, str(seen.names_file), lenient=True)
        known = found.sources.keys() - {TIME}
        records = tuple(load([Path(path)], own)) if known else ()
    except ErError as error:
        return replace(found, trouble=_in_words(error, Path(path)))
    return replace(found, records=records)


def _in_words(error: ErError, path: Path) -> str:
    """What is wrong, without the path that was asked for, and without the advice to map its columns."""
    if not isinstance(error, InputError):
        return str(error)
    file = Path(error.path)
    where = "".join(f"{each}: " for each in (file.name * (file != path), error.key) if each)
    return f"{where}expected {error.expected}, found {error.found}".split(" (no measurement?")[0]


def said(names: Mapping[str, Any]) -> dict[str, Source]:
    """What a user says of channels; None or '' takes one away."""
    for channel in names:
        if channel != TIME and unit_of(channel) is None:
            raise UnknownName("channel", channel, (TIME, *CHANNELS))
    kept: Given = {c: v for c, v in names.items() if v not in (None, "")}
    return {**parsed(kept).sources, **{c: Source() for c in names.keys() - kept.keys()}}


def entry(text: str) -> tuple[str, Any]:
    """`damper_force=Kraft [kN]`, or `duty={from: Strom, full_scale: 1.6}`, as a channel and what is said of it."""
    channel, mark, value = (part.strip() for part in text.partition("="))
    if not mark:
        raise InputError("--set", "", 'CHANNEL=COLUMN, such as damper_force="Kraft [kN]"', text)
    if not value.startswith("{"):
        return channel, value
    try:
        return channel, yaml.safe_load(value)
    except yaml.YAMLError:
        expected = "{from: COLUMN, unit: kN, sign: -1}"
        raise InputError("--set", channel, expected, value) from None


def sure_in_words(guess: Guess) -> str:
    """`sure`, `likely` or `unsure`."""
    return "sure" if guess.sure >= SURE else "likely" if guess.sure >= LIKELY else "unsure"


def option(channel: str, guess: Guess | None = None) -> str:
    """The option that says what a channel is."""
    column = guess.offer if guess else "COLUMN [unit]"
    return f"--set {channel}={json.dumps(column, ensure_ascii=False)}"
