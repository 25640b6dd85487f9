"""Live: what is heard, what the monitor says, what the drive has not shown yet, and the verdict when it comes."""

from __future__ import annotations

import math

from nicegui import ui

from er_model_lab.output.text.units import newtons
from er_model_lab.output.text.verdict_text import verdict_sentence, verdict_title
from er_model_lab.page.panels.help import heading, helped
from er_model_lab.page.panels.panel import Host
from er_model_lab.results.result import DiagnosisResult
from er_model_lab.session.live_desk import LiveDesk

LISTED = 5
"""Regions that are asked for at once: nobody drives more."""


class LivePanel:
    """The running graph."""

    def __init__(self, host: Host) -> None:
        assert isinstance(host.desk, LiveDesk)
        self.host, self.desk = host, host.desk
        self.heard = ui.label().classes("numbers").props("role=status")
        self.monitor = ui.label().props("role=status aria-live=polite")
        self.error = helped(ui.label().classes("numbers text-lg"), "usual", "test of its limit")
        self.run = ui.label().classes("text-sm numbers").props("role=status")
        heading("To drive next", "coverage")
        self.bar = ui.linear_progress(0.0, show_value=False).props(
            'aria-label="Share of what a verdict needs"'
        )
        self.gaps = [ui.label().classes("text-sm numbers") for _ in range(LISTED)]
        heading("Verdict", "status")
        self.verdict, self.says = ui.label().classes("font-bold"), ui.label().classes("text-sm")
        self.added = ui.row().classes("w-full gap-1")
        self.job = ui.label().classes("text-sm numbers").props("role=status aria-live=polite")
        with ui.row().classes("gap-1"):
            self.learn = ui.button(
                "Diagnose what was heard", on_click=host.safely(self.desk.learn)
            )
            self.learn.props("no-caps")
            self.give = ui.button("Monitor: use this model", on_click=host.safely(self.desk.give))
            self.give.props("no-caps outline").tooltip(
                "The graph's monitor goes by the model that is shown here"
            )
        ui.checkbox("observers go over, too").props("dense").bind_value(
            self.desk, "observers"
        ).tooltip(
            "They have gains made for the model first; what they say is in the monitor's log"
        )
        ui.checkbox("diagnose by itself when the data carry it", value=self.desk.by_itself).props(
            "dense"
        ).bind_value(self.desk, "by_itself")
        self.shown: object = None

    def refresh(self) -> None:
        """Show what there is."""
        desk, running = self.desk, self.desk.jobs.running
        self.heard.text = self._heard()
        self.monitor.text, self.error.text = self._monitor(), self._error()
        self.run.text = f"planned run: {desk.run.says(desk.heard.now)}" if desk.run else ""
        self.run.set_visibility(desk.run is not None)
        self._gaps()
        job = desk.jobs.job
        ahead = f", {job.leaders[0].effect.replace('_', ' ')} ahead" if job and job.leaders else ""
        self.job.text = (
            ""
            if job is None
            else job.error or (f"{job.title}: {job.stage}{ahead}" if running else "")
        )
        for button in (self.learn, self.give):
            button.set_enabled(not running and desk.now.model is not None)
        if self.shown is not desk.result:
            self.shown = desk.result
            self._result(desk.result)

    def _heard(self) -> str:
        desk = self.desk
        where = f"/{desk.namespace.strip('/')}"
        if desk.gone:
            return f"not listening any more: {desk.gone}"
        if desk.alone:
            return f"nothing is heard in {where}: ./er up model_monitor:=true drives; ./er doctor says more"
        return f"heard in {where}: the last {desk.heard.seconds:.0f} s"

    def _monitor(self) -> str:
        desk = self.desk
        if desk.refused:
            return desk.refused
        if not desk.status:
            return "no model_monitor there: ./er up model_monitor:=true"
        mode, reason = desk.status["mode"], desk.status["reason"]
        return f"monitor, {desk.running or 'its model'}: {mode}{f'; {reason}' if reason else ''}"

    def _error(self) -> str:
        heard = self.desk.heard
        now, usual, ratio = heard.error(), heard.said("usual"), heard.said("ratio")
        if math.isnan(now):
            return "no live error yet"
        expected = (
            f", usual {newtons(usual)}, test {ratio:.2f} of its limit" if usual > 0.0 else ""
        )
        return f"live error {newtons(now)}{expected}"

    def _gaps(self) -> None:
        shown = self.desk.shown
        gaps = [s for s in shown if not s.done]
        self.bar.set_value(round(sum(s.share for s in shown) / len(shown), 2) if shown else 0.0)
        words = [f"{s.do} ({s.have:.3g} of {s.need:.3g} {s.unit})" for s in gaps[:LISTED]]
        if shown and not gaps:
            words = ["nothing: the drive shows everything that an effect needs"]
        for k, label in enumerate(self.gaps):
            label.text = words[k] if k < len(words) else ""
            label.set_visibility(k < len(words))

    def _result(self, result: DiagnosisResult | None) -> None:
        self.added.clear()
        self.verdict.text = "" if result is None else verdict_title(result.view)
        self.says.text = "" if result is None else verdict_sentence(result.view)
        model = self.desk.now.model
        for effect in result.effects if result is not None and model is not None else ():
            if (
                model is not None
                and effect in model.catalogue.names
                and effect not in model.effects
            ):
                add = self.host.safely(lambda effect=effect: self.desk.add(effect))
                with self.added:
                    ui.button(f"Add {model.catalogue[effect].title}", on_click=add).props(
                        "no-caps"
                    )
