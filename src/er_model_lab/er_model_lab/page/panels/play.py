"""Play: a switch for every effect, a slider for every parameter; curves and error follow while one is dragged."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from er_models.model import Model
from nicegui import ui

from er_model_lab.output.text.units import short
from er_model_lab.page.panels.help import heading
from er_model_lab.page.panels.panel import Host
from er_model_lab.session.slider import POSITIONS, Slider


class PlayPanel:
    """The effects of the model."""

    def __init__(self, host: Host) -> None:
        self.host, self.shown = host, object()
        self.rows: dict[tuple[str, str], Callable[[float], None]] = {}
        heading("Effects and their parameters", "deviation")
        self.box = ui.column().classes("w-full gap-1")

    def refresh(self) -> None:
        """Show the model: anew where its effects differ, else its values."""
        now = self.host.desk.now
        if now.model is None:
            return
        key = (tuple(now.model.effects), tuple(now.off), id(now.fitted))
        if key != self.shown:
            self.shown = key
            self._build(now.model, dict(now.off))
        for (effect, parameter), put in self.rows.items():
            put(now.model.value(effect, parameter))

    def _build(self, model: Model, off: dict[str, Any]) -> None:
        self.rows, desk = {}, self.host.desk
        self.box.clear()
        with self.box:
            for effect in (*model.effects, *off):
                on = effect in model.effects
                with ui.row().classes("w-full items-center no-wrap"):
                    act = self.host.safely(
                        lambda e, name=effect: desk.take(desk.now.switched(name, on=e.value))
                    )
                    title = model.catalogue[effect].title
                    ui.switch(title, value=on, on_change=act).tooltip(
                        model.catalogue[effect].physics
                    )
                if on:
                    for parameter in model.catalogue[effect].parameters:
                        self._parameter(model, effect, parameter.name)
            for term in model.terms:
                ui.label(f"{term.name}: measured, not explained").classes("muted")

    def _parameter(self, model: Model, effect: str, name: str) -> None:
        desk, q = self.host.desk, model.catalogue[effect].parameter(name)
        scale, unit = Slider(*model.bounds(effect, name)), "" if q.unit == "1" else q.unit
        label = f"{name}{f' [{unit}]' if unit else ''}"
        sd = (desk.now.fitted or model).deviations.get(effect, {}).get(name)
        quiet = [False]

        def move(value: float | None) -> None:
            if value is None or value == desk.now.known.value(effect, name):
                return
            desk.take(desk.now.set(effect, name, float(value)))
            put(float(value))

        with ui.column().classes("w-full gap-0 pl-4"):
            with ui.row().classes("w-full items-center justify-between no-wrap"):
                ui.label(label).classes("text-sm").tooltip(
                    f"{q.meaning}; {short(scale.low)} to {short(scale.high)} {unit}"
                )
                said = "" if sd is None else f"\N{PLUS-MINUS SIGN} {short(sd, 2)}"
                ui.label(said).classes("text-xs muted numbers")
                number = ui.number(value=model.value(effect, name), format="%.5g").props(
                    f'dense borderless input-class="text-right" aria-label="{effect} {name} [{q.unit}]"'
                ).classes("w-28 numbers")  # fmt: skip
                number.on("change", self.host.safely(lambda: move(number.value)), [])
            slider = ui.slider(
                min=0, max=POSITIONS, step=1, value=scale.position(model.value(effect, name))
            )
            slider.props(f'dense aria-label="{effect} {name}" data-parameter="{effect}.{name}"')
            dragged = self.host.safely(lambda e: move(scale.value(e.value)))
            slider.on_value_change(lambda e: None if quiet[0] else dragged(e))

        def put(value: float) -> None:
            quiet[0] = True
            number.set_value(float(f"{value:.5g}"))
            if round(scale.position(value)) != slider.value:
                slider.set_value(round(scale.position(value)))
            quiet[0] = False

        self.rows[effect, name] = put
