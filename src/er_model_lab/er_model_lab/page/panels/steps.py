"""Steps: the error falls, and any step is taken back."""

from __future__ import annotations

from nicegui import ui

from er_model_lab.page import plots
from er_model_lab.page.panels.help import heading
from er_model_lab.page.panels.panel import Host
from er_model_lab.session.fall import Stage


class StepsPanel:
    """What was done, with the waterfall of the error."""

    def __init__(self, host: Host) -> None:
        self.host = host
        heading("The error step by step", "waterfall", "noise floor", "measured term")
        self.plot = ui.plotly(plots.waterfall([], None, host.theme)).classes("w-full")
        self.plot.props(
            'role="figure" aria-label="The error of the model as given and after each step"'
        )
        self.added = ui.column().classes("w-full gap-0")
        self.list = ui.column().classes("w-full gap-0")

    def refresh(self) -> None:
        """Show all steps, those that were taken back in grey."""
        desk = self.host.desk
        floor = desk.result.noise_floor if desk.result else None
        fall = desk.fall()
        self.plot.update_figure(plots.waterfall(fall, floor, self.host.theme))
        self._added(fall)
        self.list.clear()
        here = len(desk.session.past) - 1
        with self.list:
            for k, state in enumerate((*desk.session.past, *desk.session.future)):
                go = self.host.safely(lambda k=k: desk.go(desk.session.at(k)))
                words = f"{k}. {state.step.says}"
                if "parameter" in state.step.values:
                    name = str(state.step.values["parameter"])
                    words += f": {name} = {state.step.values[name]:.4g}"
                button = (
                    ui.button(words, on_click=go)
                    .props("flat dense no-caps align=left")
                    .classes("w-full")
                )
                if k == here:
                    button.props('color=accent icon=arrow_right aria-current="step"')
                elif k > here:
                    button.classes("opacity-70 italic")

    def _added(self, fall: list[Stage]) -> None:
        """What was added and is in the model still, each to be taken back."""
        desk, model = self.host.desk, self.host.desk.now.model
        there = set() if model is None else {*model.effects, *(t.name for t in model.terms)}
        self.added.clear()
        with self.added:
            for name in dict.fromkeys(n for stage in fall for n in stage.added if n in there):
                words = name.replace("_", " ")
                with ui.row().classes("w-full items-center justify-between no-wrap"):
                    ui.label(f"+ {words}")
                    back = self.host.safely(lambda name=name: desk.take_back(name))
                    ui.button("Take back", on_click=back).props(
                        f'flat dense no-caps aria-label="Take back {words}"'
                    ).classes("shrink-0 pr-2")
