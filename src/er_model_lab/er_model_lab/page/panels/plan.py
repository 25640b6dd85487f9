"""The run that would decide: whom to tell apart, and what was planned for it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from er_models.errors import ErError
from er_models.model import Model
from nicegui import ui

from er_model_lab.live.planned_run import moves
from er_model_lab.output.report.sections.programs import head, row, section
from er_model_lab.output.text.units import percent
from er_model_lab.output.text.verdict_text import verdict_sentence, verdict_title
from er_model_lab.page import plots
from er_model_lab.page.panels.help import helped
from er_model_lab.page.panels.panel import Host
from er_model_lab.planning.question import ask
from er_model_lab.results.result import DiagnosisResult, PlanResult
from er_model_lab.session.live_desk import LiveDesk

LOOK = 0.5
"""Time between two looks at a run that is driven [s]."""


def rivals(result: DiagnosisResult, model: Model, effect: str) -> list[str]:
    """Whom an effect can be taken for: those that these data cannot tell from it, then those of its signature."""
    if effect not in model.catalogue.names:
        return []
    tied = [o for c in result.candidates if c.effect == effect for o in c.confounded_with]
    known = dict.fromkeys([*tied, *model.catalogue[effect].signature.rivals])
    return [other for other in known if _can_be_planned(model, effect, other)]


def _can_be_planned(model: Model, effect: str, other: str) -> bool:
    try:
        ask(model, (effect, other), None)
    except ErError:
        return False
    return True


def offer(words: str, act: Callable[[], Any]) -> None:
    """A button that plans a run."""
    ui.button(words, on_click=act).props("outline dense no-caps align=left")


def show(result: PlanResult, host: Host) -> None:
    """What was planned: the verdict, the pieces, the table of programs, and road, motion and duty drawn."""
    ui.label(verdict_title(result.view)).classes("text-lg font-bold").props(
        "role=heading aria-level=2"
    )
    ui.label(verdict_sentence(result.view))
    ui.label("Take holds the run as a file for the rig, or for ./er up program:=run.yaml").classes(
        "muted"
    )
    if isinstance(host.desk, LiveDesk) and result.program is not None:
        _drive(host, host.desk, moves(result.program, dict(result.view.result)))
    told = result.view.result
    for program in told["programs"][:1]:
        for k, piece in enumerate(program["pieces"]):
            ui.label(f"{k + 1}. {piece}").classes("text-sm")
    for effect, power in told["measurements"].items():
        low, high = power["interval"]
        says = f"expected power, if it is {effect.replace('_', ' ')}: named in {power['right']} of {power['runs']}"
        helped(
            ui.label(f"{says} simulated runs ({percent(low)} to {percent(high)})").classes(
                "text-sm"
            ),
            "expected power",
        )
    helped(ui.label("How far it tells them apart").classes("w-fit"), "separation")
    table([row(told, p) for p in told["programs"]], head(told))
    made = section(result.view)
    for figure in made.figures[:1] if made else ():
        plot = ui.plotly(plots.of_report(figure, host.theme)).classes("w-full")
        plot.props(f'role="figure" aria-label="{figure.alt}"')


def _drive(host: Host, desk: LiveDesk, words: list[str]) -> None:
    """Buttons that have the running graph drive the run once it was said yes, and end it; what came of it."""

    async def asked() -> None:
        with ui.dialog() as dialog, ui.card():
            ui.label("Drive this run in the running graph?").classes("text-lg").props(
                "role=heading aria-level=2"
            )
            for line in words:
                ui.label(line).classes("text-sm")
            with ui.row():
                ui.button("Drive it", on_click=lambda: dialog.submit(True)).props("no-caps")
                ui.button("Cancel", on_click=lambda: dialog.submit(False)).props("flat no-caps")
        agreed = await dialog
        dialog.delete()
        if agreed:
            desk.drive()

    with ui.row().classes("gap-1"):
        go = ui.button("Drive it now in the running graph", on_click=host.safely(asked))
        end = ui.button("End the run", on_click=host.safely(desk.end_run))
    for button in (go, end):
        button.props("dense no-caps outline")
    said = ui.label().classes("text-sm numbers").props("role=status aria-live=polite")

    def look() -> None:
        go.set_enabled(not desk.driving)
        end.set_visibility(desk.driving)
        said.text = desk.run.says(desk.heard.now) if desk.run is not None else ""

    look()
    ui.timer(LOOK, look)


def table(rows: list[list[str]], names: list[str]) -> None:
    """A table that scrolls where it is wider than the panel."""
    with (
        ui.element("div").classes("w-full overflow-x-auto").props("tabindex=0"),
        ui.element("table").classes("text-sm numbers"),
    ):
        for kind, cells in (("th", names), *(("td", cells) for cells in rows)):
            with ui.element("tr"):
                for cell in cells:
                    with ui.element(kind).classes("px-1 text-left"):
                        ui.label(cell.replace("_", " "))
