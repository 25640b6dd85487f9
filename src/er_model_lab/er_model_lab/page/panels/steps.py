"""Steps: the error falls, and any step is taken back."""

from __future__ import annotations

from nicegui import ui

from er_model_lab.page import plots
from er_model_lab.page.panels.panel import Host


class StepsPanel:
    """What was done, with the waterfall of the error."""

    def __init__(self, host: Host) -> None:
        self.host = host
        self.plot = ui.plotly(plots.waterfall([], None, host.theme)).classes("w-full")
        self.plot.props(
            'role="figure" aria-label="The error of the model as given and after each step"'
        )
        self.list = ui.column().classes("w-full gap-0")

    def refresh(self) -> None:
        """Show all steps, those that were taken back in grey."""
        desk = self.host.desk
        floor = desk.result.noise_floor if desk.result else None
        self.plot.update_figure(plots.waterfall(desk.fall(), floor, self.host.theme))
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
