"""The dialogue that says what the columns of somebody's own file are."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import numpy as np
from er_records.mapping.guess import LIKELY, Guess
from er_records.mapping.mapping import Mapped, sure_in_words
from er_records.mapping.survey import Seen
from er_records.record import CHANNELS
from nicegui import ui

from er_model_lab.output.report.thin import min_max
from er_model_lab.output.text.units import short

NONE = "(none)"
ASKED = ("t", "deflection", "deflection_velocity", "duty", "damper_force")
"""Channels that are always asked for; others where they are guessed."""
PREVIEW = (120, 26)
"""Size of the picture of a column [px]."""


class MappingDialog:
    """Columns with their ranges and pictures, a choice for each channel, and what comes of it."""

    def __init__(self, path: Path, found: Mapped) -> None:
        self.path, self.found = path, found
        self.given: dict[str, Any] = {}

    async def asked(self) -> dict[str, Any] | None:
        """What the user says, as `load(names=...)` takes it; None where the dialogue was left."""
        with ui.dialog() as dialog, ui.card().classes("w-full max-w-3xl"):
            ui.label(f"What are the columns of {self.path.name}?").classes("text-lg").props(
                "role=heading aria-level=2"
            )
            self._columns()
            self._choices()
            self.says = ui.label().props("role=status")
            with ui.row():
                self.use = ui.button("Use", on_click=lambda: dialog.submit(self.found.names))
                ui.button("Cancel", on_click=lambda: dialog.submit(None)).props("flat")
        self._judge()
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

    def _choices(self) -> None:
        headers = [s.header for s in self.found.survey.columns]
        more = [c for c in CHANNELS if c in self.found.guesses and c not in ASKED]
        for channel in (*ASKED, *more):
            guess = self.found.guesses.get(channel)
            with ui.row().classes("w-full items-center no-wrap"):
                chosen = ui.select(
                    [NONE, *headers], label=channel,
                    value=guess.seen.header if guess and guess.sure >= LIKELY else NONE,
                ).classes("grow").props("dense")  # fmt: skip
                flip = ui.checkbox("flip sign").props("dense")
                if guess:
                    ui.label(_said(guess)).classes("text-xs muted").tooltip(", ".join(guess.why))

                async def change(
                    _: Any = None, channel: str = channel, chosen: Any = chosen, flip: Any = flip
                ) -> None:
                    column = None if chosen.value == NONE else chosen.value
                    self.given[channel] = (
                        {"from": column, "sign": -1} if column and flip.value else column
                    )
                    await self._again()

                chosen.on_value_change(change)
                flip.on_value_change(change)

    async def _again(self) -> None:
        from er_model_lab.verbs.map import map as mapped

        self.found = await asyncio.to_thread(mapped, self.path, dict(self.given))
        self._judge()

    def _judge(self) -> None:
        good = bool(self.found.records) and not self.found.trouble
        seconds = sum(len(r) * r.dt for r in self.found.records)
        self.says.text = (
            f"reads as {seconds:.4g} s of measurements"
            if good
            else self.found.trouble or "no column is known yet"
        )
        self.use.set_enabled(good)


def _said(guess: Guess) -> str:
    """How sure a guess is; one that is too weak to be taken is only named."""
    return sure_in_words(guess) if guess.sure >= LIKELY else f"perhaps {guess.seen.header}"


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
