"""Learn: which effect is missing, as it is judged; the verdict, the cards, and the effect that is added."""

from __future__ import annotations

from typing import Any

from er_models.effect import Effect
from er_models.errors import InputError
from er_models.model import Model
from nicegui import ui

from er_model_lab.output.text.units import newtons
from er_model_lab.output.text.verdict_text import verdict_sentence, verdict_title
from er_model_lab.page import plots
from er_model_lab.page.panels import plan
from er_model_lab.page.panels.help import helped
from er_model_lab.page.panels.panel import Host
from er_model_lab.results.result import DiagnosisResult

NUMBERS = {
    "p value": "p value", "effect size, training data": "effect size",
    "error on held-out data, without and with it": "held out",
}  # fmt: skip
"""Numbers of a card whose words are explained."""


class LearnPanel:
    """Diagnose, improve, cancel; who is ahead; what was found."""

    def __init__(self, host: Host) -> None:
        self.host, desk = host, host.desk
        with ui.row().classes("gap-1"):
            self.buttons = [
                ui.button("Diagnose", on_click=host.safely(desk.learn)),
                ui.button(
                    "Improve", on_click=host.safely(lambda: desk.improve(measured_terms=self.terms.value))
                ).props("outline").tooltip("Diagnose and add, again and again, until nothing more is found"),
            ]  # fmt: skip
            self.cancel = ui.button("Cancel", on_click=desk.jobs.cancel).props(
                "outline color=accent"
            )
        self.terms = ui.checkbox("learn what no effect explains as a measured term").props("dense")
        with ui.row().classes("w-full items-center no-wrap"):
            self.effect = ui.select({}, with_input=True, label="Effect to add").classes("grow")
            self.effect.props('dense options-dense clearable aria-label="Effect to add"')
            self.buttons.append(ui.button("Add", on_click=host.safely(self._add)).props("outline"))
        self.stage = ui.label("").props("role=status aria-live=polite")
        self.bar = ui.linear_progress(0.0, show_value=False).props(
            'aria-label="Progress of the job"'
        )
        self.ahead = ui.column().classes("w-full gap-0")
        self.found = ui.column().classes("w-full gap-1")
        self.shown: object = None

    def refresh(self) -> None:
        """Show the job as it is, and the result once."""
        desk, job = self.host.desk, self.host.desk.jobs.job
        running = desk.jobs.running
        for button in self.buttons:
            button.set_enabled(not running)
        self.cancel.set_visibility(running)
        self.bar.set_visibility(running)
        if job is not None and job.title != "open the data":
            share = job.done / job.total if job.total else 0.0
            self.bar.set_value(share)
            self.stage.text = (
                f"{job.title}: {job.stage} {job.done} of {job.total}" if running else job.error
            )
            self.ahead.clear()
            with self.ahead:
                for k, leader in enumerate(job.leaders[:8] if running else ()):
                    says = (
                        f"{k + 1}. {_title(desk.now.known, leader.effect)}: {newtons(leader.rmse)}"
                    )
                    ui.label(f"{says}, {newtons(leader.evidence)} less").classes("numbers")
        model = desk.now.model
        if model is not None:
            effects = {e.name: e.title for e in model.catalogue.effects if may_be_added(model, e)}
            if effects != self.effect.options:
                self.effect.set_options(effects, value=None)
        key = (id(desk.result), id(desk.planned), self.host.theme)
        if key != self.shown:
            self.shown = key
            self.found.clear()
            if desk.result is not None:
                with self.found:
                    self._result(desk.result)
            if desk.planned is not None:
                with self.found:
                    plan.show(desk.planned, self.host)

    def _add(self) -> None:
        if not self.effect.value:
            raise InputError("effect", "", "an effect to add", "none")
        self.host.desk.add(str(self.effect.value))

    def _result(self, result: DiagnosisResult) -> None:
        from er_model_lab.output.report.sections.cards import section

        ui.label(verdict_title(result.view)).classes("text-lg font-bold").props(
            "role=heading aria-level=2"
        )
        ui.label(verdict_sentence(result.view))
        for reason in result.reasons:
            ui.label(reason).classes("text-sm muted")
        for asked in result.view.result.get("next_plans") or ():
            self._offer(asked)
        made = section(result.view)
        for card in made.facts["cards"] if made else []:
            self._card(card, plan.rivals(result, self.host.desk.now.known, card["effect"]))

    def _offer(self, asked: dict[str, Any]) -> None:
        """The run that would decide, to be planned."""
        model = self.host.desk.now.known
        between = tuple(asked.get("between", ()))
        which = " or ".join(_title(model, e) for e in between or (asked["reveal"],))
        act = self.host.safely(
            lambda: self.host.desk.plan(between=between, reveal=asked.get("reveal"))
        )
        plan.offer(f"Plan the run that shows: {which}", act)

    def _card(self, card: dict[str, Any], rivals: list[str]) -> None:
        desk = self.host.desk
        with (
            ui.expansion(f"{card['title']} ({card['status']})")
            .classes("w-full")
            .props("dense") as box
        ):
            drawn: list[ui.plotly] = []

            def draw() -> None:
                if box.value and not drawn and card["figure"] is not None:
                    with picture:
                        plot = ui.plotly(plots.of_report(card["figure"], self.host.theme)).classes(
                            "w-full"
                        )
                        drawn.append(
                            plot.props(f'role="figure" aria-label="{card["figure"].alt}"')
                        )

            effect = str(card["effect"])
            known = desk.now.known.catalogue
            if effect in known.names and may_be_added(desk.now.known, known[effect]):
                ui.button("Add", on_click=self.host.safely(lambda: desk.add(effect))).props(
                    f'dense aria-label="Add {card["title"]}"'
                )
            ui.label(card["physics"]).classes("text-sm")
            for each in card["equations"]:
                if each.mathml:
                    ui.html(each.mathml, sanitize=False).classes("text-sm")
                else:
                    ui.label(each.plain).classes("text-sm font-mono")
            shows = f"shows as: {card['mark']}; tell it by: {card['experiment']}"
            helped(ui.label(shows).classes("text-sm muted"), "signature")
            for name, value in [*card["numbers"], *card["parameters"]]:
                said = ui.label(f"{name}: {value}").classes("text-sm numbers w-fit")
                if name in NUMBERS:
                    helped(said, NUMBERS[name])
            if card["confounded"]:
                said = ui.label(f"cannot be told apart from {card['confounded']}")
                helped(said.classes("text-sm warning"), "status")
            ui.label(card["reason"]).classes("text-sm")
            if rivals:
                helped(ui.label("Rivals").classes("w-fit"), "rivals")
            for other in rivals:
                act = self.host.safely(lambda other=other: desk.plan(between=(effect, other)))
                title = _title(desk.now.known, other)
                plan.offer(f"Plan the run that tells it from {title}", act)
            picture = ui.column().classes("w-full")
            box.on_value_change(draw)


def may_be_added(model: Model, effect: Effect) -> bool:
    """Whether an effect can be learnt from a damper's force, and is not in the model yet."""
    fit = effect.knowable and effect.stage not in ("core", "fault", "vehicle")
    return fit and effect.name not in model.effects


def _title(model: Model, effect: str) -> str:
    """Title of an effect, or of several joined by +."""
    known = model.catalogue.names
    return " + ".join(
        model.catalogue[e.strip()].title if e.strip() in known else e.strip()
        for e in effect.split("+")
    )
