"""The dialogue that says what the columns of somebody's own file are."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable
from pathlib import Path
from typing import Any

import numpy as np
from er_records.mapping.guess import LIKELY, Guess, si_of
from er_records.mapping.mapping import Mapped, sure_in_words
from er_records.mapping.survey import Seen
from er_records.readers.names import TIME, Source
from er_records.readers.units import FIELD, UNITS
from er_records.record import CHANNELS
from nicegui import ui

from er_model_lab.output.report.thin import min_max
from er_model_lab.output.text.units import short

NONE, CONSTANT, RATE = "(none)", "(constant)", "(steps of one rate)"
ASKED = (TIME, "deflection", "deflection_velocity", "duty", "damper_force")
"""Channels that are always asked for; others where they are guessed."""
MADE = {TIME: (RATE, "rate", "Hz"), "duty": (CONSTANT, "value", "0 ... 1")}
"""Channels that need no column: how the choice is called, and the key and label of the number that makes them."""
PREVIEW = (120, 26)
"""Size of the picture of a column [px]."""


class MappingDialog:
    """Columns with their ranges and pictures, a choice for each channel, and what comes of it."""

    def __init__(self, path: Path, found: Mapped) -> None:
        self.path, self.found = path, found
        self.choices: list[Choice] = []
        self.asks = 0

    async def asked(self) -> dict[str, Any] | None:
        """What the user says, as `load(names=...)` takes it; None where the dialogue was left."""
        with (
            ui.dialog().props('aria-label="Columns of a file"') as dialog,
            ui.card().classes("w-full max-w-4xl"),
        ):
            ui.label(f"What are the columns of {self.path.name}?").classes("text-lg").props(
                "role=heading aria-level=2"
            )
            self._columns()
            with ui.column().classes("w-full gap-1") as self.rows:
                guessed = [c for c in CHANNELS if c in self.found.guesses and c not in ASKED]
                self.choices = [Choice(self, channel) for channel in (*ASKED, *guessed)]
            self.more = ui.select([], label="One more channel", on_change=self._one_more).classes(
                "w-64"
            )
            self.more.props("dense options-dense")
            self.says = ui.label().props("role=status")
            with ui.row():
                self.use = ui.button("Use", on_click=lambda: dialog.submit(self.found.names))
                ui.button("Cancel", on_click=lambda: dialog.submit(None)).props("flat")
        self.judge()
        said: dict[str, Any] | None = await dialog
        dialog.delete()
        return said

    def _columns(self) -> None:
        with ui.element("table").classes("w-full text-sm numbers"):
            for seen in self.found.survey.columns[:60]:
                with ui.element("tr"):
                    for text in (seen.header, f"{short(seen.low)} to {short(seen.high)}"):
                        with ui.element("td"):
                            ui.label(text)
                    with ui.element("td"):
                        ui.html(picture(seen), sanitize=False)

    async def again(self) -> None:
        """Guess anew beside what the user says by now."""
        from er_model_lab.verbs.map import map as mapped

        self.asks += 1
        mine, given = self.asks, {c.channel: c.given for c in self.choices if c.touched}
        found = await asyncio.to_thread(mapped, self.path, given)
        if mine == self.asks:  # nothing was said since
            self.found = found
            self.judge()

    def _one_more(self, event: Any) -> None:
        """A row for a channel that is not asked for as a rule."""
        if event.value:
            with self.rows:
                self.choices.append(Choice(self, event.value))
            self.judge()

    def judge(self) -> None:
        """Show what counts now, and what comes of it."""
        for choice in self.choices:
            choice.show()
        self.more.set_options(
            [c for c in CHANNELS if c not in {x.channel for x in self.choices}], value=None
        )
        missing = [f"{c.channel}: {c.open}" for c in self.choices if c.open]
        good = bool(self.found.records) and not self.found.trouble and not missing
        seconds = sum(len(r) * r.dt for r in self.found.records)
        parts = len(self.found.records)
        self.says.text = (
            f"reads as {seconds:.4g} s of measurements" + f" in {parts} parts" * (parts > 1)
            if good
            else "; ".join(missing) or self.found.trouble or "no column is known yet"
        )
        self.use.set_enabled(good)


class Choice:
    """What one channel is: column, unit, factor or full scale, and sign; what the user leaves open is guessed."""

    def __init__(self, dialog: MappingDialog, channel: str) -> None:
        self.dialog, self.channel = dialog, channel
        self.touched: set[str] = set()
        self.shown: dict[str, Any] = {}
        headers = [s.header for s in dialog.found.survey.columns]
        made = [MADE[channel][0]] if channel in MADE else []
        units = [*UNITS[si_of(channel)], *(FIELD if channel == "duty" else ())]
        with ui.row().classes("w-full items-center gap-2"):
            self.parts: dict[str, Any] = {
                "from": ui.select([NONE, *made, *headers], label=channel).classes("grow"),
                "unit": ui.select({"": "stated, or SI", **{u: u for u in units}}, label="unit").classes("w-28"),
                "number": ui.input(label=self.factor, validation=self._wrong).classes("w-24"),
                "sign": ui.checkbox("flip sign").classes("w-24"),
            }  # fmt: skip
            with ui.element("div").classes("w-32"):
                self.perhaps = ui.button(on_click=self._take).props("flat dense no-caps size=12px")
                self.said = ui.label().classes("text-xs muted")
                with self.said:
                    self.why = ui.tooltip("")
        self.parts["number"].props("hide-bottom-space debounce=500")
        if channel == TIME:
            self.parts["sign"].style("visibility: hidden")
        for part, widget in self.parts.items():
            widget.props("dense").on_value_change(lambda e, part=part: self._heard(part, e.value))

    @property
    def factor(self) -> str:
        """What the number is beside a column."""
        return "1 is" if self.channel == "duty" else "times"

    @property
    def given(self) -> Any:
        """What the user says of it, as `names=` takes it; None where it has no column."""
        column, unit, number, sign = (
            self.parts[k].value for k in ("from", "unit", "number", "sign")
        )
        if column == NONE:
            return None
        if self._makes(column):
            return {MADE[self.channel][1]: numbers_in(number)}
        said: dict[str, Any] = {"from": column}
        if "unit" in self.touched and unit:
            said["unit"] = unit
        if "number" in self.touched and number:
            said["full_scale" if self.channel == "duty" else "scale"] = numbers_in(number)
        if "sign" in self.touched:
            said["sign"] = -1 if sign else 1
        return said

    @property
    def open(self) -> str:
        """What is still to be said of what the user gave; '' where nothing is."""
        number = self.parts["number"].value
        if wrong := self._wrong(number):
            return wrong
        if self._makes(self.parts["from"].value) and not number:
            return "a number"
        guess = self.dialog.found.guesses.get(self.channel)
        return guess.why[-1] if self.touched and guess is not None and guess.sure < LIKELY else ""

    def show(self) -> None:
        """What counts now, said or guessed."""
        guess = self.dialog.found.guesses.get(self.channel)
        weak = guess is not None and guess.sure < LIKELY and not self.touched
        self.perhaps.set_visibility(weak)
        self.said.set_visibility(guess is not None and not weak)
        if guess is not None:
            self.perhaps.text = f"perhaps {guess.offer}"
            self.said.text, self.why.text = sure_in_words(guess), ", ".join(guess.why)
        if self.open:
            self.said.text = self.open
        source = Source() if guess is None or weak else guess.source
        if not self._makes(self.parts["from"].value):
            self._set("from", guess.seen.header if guess is not None and not weak else NONE)
            self._set("unit", source.unit if source.unit in self.parts["unit"].options else "")
            factor = source.full_scale if self.channel == "duty" else source.scale
            typed = self.parts["number"].value
            if not self._wrong(typed) and (numbers_in(typed) if typed else None) != factor:
                self._set("number", "" if factor is None else f"{factor:.9g}")
            self._set("sign", source.sign < 0.0)
        column = self.parts["from"].value
        for part in ("unit", "sign"):
            self.parts[part].set_enabled(column != NONE and not self._makes(column))
        self.parts["number"].set_enabled(column != NONE)
        label = MADE[self.channel][2] if self._makes(column) else self.factor
        self.parts["number"].props(f'label="{label}"')

    def _makes(self, column: str) -> bool:
        return self.channel in MADE and column == MADE[self.channel][0]

    def _wrong(self, number: str) -> str | None:
        """What is wrong with the number that was typed."""
        try:
            found = numbers_in(number) if number else 1.0
        except ValueError:
            return "no number"
        if self._makes(self.parts["from"].value) and self.channel != TIME:
            return None
        if isinstance(found, list):
            return "one number"
        return None if found > 0.0 else "above 0"

    def _set(self, part: str, value: Any) -> None:
        """Show a value that the user did not give."""
        self.shown[part] = value
        self.parts[part].set_value(value)

    def _heard(self, part: str, value: Any) -> Awaitable[None] | None:
        """What follows from a change; nothing where the program made it."""
        if part in self.shown and value == self.shown[part]:
            return None
        self.shown[part] = value
        self.touched = {"from"} if part == "from" else {*self.touched, "from", part}
        if self._wrong(self.parts["number"].value) or (
            self._makes(self.parts["from"].value) and not self.parts["number"].value
        ):
            self.dialog.judge()  # its number is still to be given
            return None
        return self.dialog.again()

    def _take(self) -> None:
        """Use the column that is offered, in the unit that is."""
        guess: Guess = self.dialog.found.guesses[self.channel]
        unit = guess.offer.removeprefix(guess.seen.header).strip(" []")
        self.parts["from"].set_value(guess.seen.header)
        if unit:
            self.parts["unit"].set_value(unit)


def numbers_in(text: str) -> float | list[float]:
    """A number, or several parted by commas: a constant for each part of the record."""
    each = [float(part) for part in text.split(",")]
    return each if len(each) > 1 else each[0]


def picture(seen: Seen) -> str:
    """The course of a column as a small drawing."""
    rows = min_max(seen.samples, PREVIEW[0])
    y = seen.samples[rows]
    low, high = float(np.nanmin(y)), float(np.nanmax(y))
    x = np.linspace(1, PREVIEW[0] - 1, y.size)
    up = PREVIEW[1] - 2 - (PREVIEW[1] - 4) * (y - low) / ((high - low) or 1.0)
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, up, strict=True) if np.isfinite(b))
    return (
        f'<svg width="{PREVIEW[0]}" height="{PREVIEW[1]}" role="img" aria-label="course of the column">'
        f'<polyline points="{points}" fill="none" stroke="currentColor"/></svg>'
    )
