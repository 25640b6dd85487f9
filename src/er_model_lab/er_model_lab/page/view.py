"""One browser's view of the desk: header, panels, plots; redrawn where the desk has changed."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable
from functools import wraps
from time import monotonic
from typing import Any

from er_models.errors import ErError
from er_models.shipped import names
from nicegui import ui
from nicegui.events import GenericEventArguments

from er_model_lab.live.heard import Heard
from er_model_lab.output.text.units import newtons
from er_model_lab.page import live_plots, plots
from er_model_lab.page.panels.data import DataPanel
from er_model_lab.page.panels.help import STYLE as HELP
from er_model_lab.page.panels.help import described, helped, show_all
from er_model_lab.page.panels.learn import LearnPanel
from er_model_lab.page.panels.live import LivePanel
from er_model_lab.page.panels.panel import Host, Panel
from er_model_lab.page.panels.play import PlayPanel
from er_model_lab.page.panels.steps import StepsPanel
from er_model_lab.page.panels.take import TakePanel
from er_model_lab.session.desk import Desk
from er_model_lab.session.live_desk import LiveDesk
from er_model_lab.session.sight import Selection, tile_at

PERIOD = 0.15
"""How often a page looks for what others and jobs have changed [s]."""
PLOTS: dict[str, tuple[Callable[[Desk, plots.Theme], plots.Json], str]] = {
    "force": (plots.force, "Measured and predicted force over time, and what is left below"),
    "map": (
        plots.residual_map,
        "Map of what is left over velocity and deflection; click a tile to select it",
    ),
    "loops": (plots.force_loops, "Loops of force over velocity, measured and predicted"),
    "spectrum": (plots.residual_spectrum, "Spectrum of what is left"),
}
"""What is drawn, and its words for who cannot see it."""
LIVE: dict[str, tuple[Callable[[Heard, plots.Theme], plots.Json], int]] = {
    "error": (live_plots.error, 2), "force": (live_plots.force, 1), "map": (live_plots.residual_map, 4),
    "loops": (live_plots.loops, 2), "spectrum": (live_plots.spectrum, 4),
}  # fmt: skip
"""The same of a running graph, and every how many turns each is drawn anew."""
TURN = 0.5
"""Time of a turn [s]."""
FIRST, REST = "force", 0.3
"""The plot that follows a slider at once, and how long that rests until the others do, which take a browser longer [s].
"""
PATIENCE = 2.0
"""How long a browser may draw the curves before it gets what is new all the same [s]."""
HEIGHTS = {"error": 190, "force": 400}
"""Of the places of plots, else `HEIGHT` [px]."""
HEIGHT = 300
AHEAD = '<script type="module">import("nicegui-plotly")</script>'
"""Has the browser fetch what draws the plots while it makes the rest of the page."""
STYLE = """
.lab { display: grid; grid-template-columns: minmax(330px, 400px) 1fr; gap: 12px; width: 100%; align-items: start; }
.lab > * { min-width: 0; }
.lab .views { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: 8px; }
.lab .views .wide { grid-column: 1 / -1; }
.numbers { font-variant-numeric: tabular-nums; }
.finding .q-btn__content { text-align: left; font-weight: 400; }
.muted { color: #55606e; } .body--dark .muted { color: #b3bcc8; }
.body--dark .text-primary { --q-primary: #7db8ea; } .body--dark .text-accent { --q-accent: #e79cc6; }
.fail { color: #a33f00; } .body--dark .fail { color: #ff9a6a; }
.warning { color: #7d5600; } .body--dark .warning { color: #e9b44c; }
:focus-visible { outline: 3px solid #1976d2 !important; outline-offset: 1px; }
.lab .q-tab { padding: 0 9px; }
.lab :is(.q-btn, .q-item, .q-checkbox__label, .q-toggle__label, .q-tab) { user-select: text; }
.q-uploader { width: 100%; max-height: 150px; } .q-uploader__file .q-btn { display: none; }
@media (max-width: 1000px) {
  .lab { grid-template-columns: minmax(0, 1fr); } .lab .views { grid-template-columns: minmax(0, 1fr); }
}
"""


WITHOUT_DATA = "No data yet: drop files under Data."
WITHOUT_MODEL = "The data are read. Begin with a model under Data: a new one scaled to them, a shipped one, or a file."


class View:
    """What one browser shows."""

    def __init__(self, desk: Desk) -> None:
        self.desk, self.theme = desk, plots.LIGHT
        self.seen, self.since, self.until = -1, 0.0, 0.0
        self.told: dict[str, tuple[int, int]] = {}
        self.places: dict[str, tuple[ui.element, str]] = {}
        self.plots: dict[str, ui.plotly] = {}
        self.live = desk if isinstance(desk, LiveDesk) else None
        self.turn, self.holding = 0, False
        ui.add_css(STYLE + HELP)
        ui.add_head_html(AHEAD)
        described()
        ui.colors(primary="#1f5f99", accent="#9c4a7c")
        self._header()
        with ui.element("div").classes("lab p-2"):
            with ui.card().classes("w-full"):
                self._panels()
            with ui.element("div").classes("views"):
                self._views()
        self.look()
        self._tell()
        self.tabs.on_value_change(self._tell)
        ui.keyboard(on_key=self._key)
        ui.timer(PERIOD, self._tick)
        if self.live is not None:
            ui.timer(TURN, self._follow)
        ui.timer(0.0, self._as_system, once=True)

    def safely(self, action: Callable[..., Any]) -> Callable[..., Awaitable[None]]:
        """An action of the user's whose errors are one line on the page."""

        @wraps(action)
        async def done(*args: Any) -> None:
            try:
                found = action(*args)
                if isinstance(found, Awaitable):
                    await found
            except ErError as error:
                ui.notify(
                    " ".join(str(error).split()),
                    type="negative",
                    multi_line=True,
                    close_button="Close",
                )
            self.look()

        return done

    def look(self) -> None:
        """Redraw the plots where the desk has changed since this browser saw it."""
        if self.seen != self.desk.revision and not self.drawing:
            self.seen = self.desk.revision
            self.draw()

    @property
    def drawing(self) -> bool:
        """Whether the browser still draws the curves that it was sent last: it gets no more until it has."""
        return monotonic() < self.until

    def _drawn(self) -> None:
        """It has."""
        self.until = 0.0
        self.look()

    def _tick(self) -> None:
        """The same with the panel that is open, which need not follow every position of a slider."""
        self.look()
        if self.since and monotonic() > self.since + REST and not self.drawing:
            self._others()
        self._tell()

    def _others(self) -> None:
        """Redraw all plots but the first."""
        self.since = 0.0
        self._draw(name for name in PLOTS if name != FIRST)

    def _tell(self) -> None:
        """Show what has changed in the panel that is open: a browser renders what nobody sees, too."""
        now, name = (self.desk.revision, self.desk.progress), str(self.tabs.value)
        if self.told.get(name) != now:
            self.told[name] = now
            self._offer()
            self.panels[name].refresh()

    def draw(self) -> None:
        """Redraw curves and numbers, which follow a parameter while it is dragged; the other plots soon."""
        desk, errors = self.desk, self.desk.errors()
        self.error.text = (
            ("" if self.live else "no prediction yet") if errors is None
            else f"error {newtons(errors.train)} learnt from, {newtons(errors.held_out)} held out"
        )  # fmt: skip
        self.second.text = self._laid()
        self.model.text = desk.now.model.name if desk.now.model else "no model"
        self.undo.set_enabled(len(desk.session.past) > 1)
        self.redo.set_enabled(bool(desk.session.future))
        self.fitted.set_enabled(
            desk.now.model is not None and desk.now.model is not desk.now.fitted
        )
        self._draw([FIRST])
        self.since = monotonic()
        self.until = self.since + PATIENCE if FIRST in self.plots and not self.following else 0.0

    def _draw(self, names: Iterable[str]) -> None:
        """Redraw plots of what was opened."""
        for name in names if self.following is None else ():
            figure = PLOTS[name][0](self.desk, self.theme)
            if name == "force" and self.holding:
                figure["layout"] |= plots.HOLDING
            self._put(name, figure)

    def _put(self, name: str, figure: plots.Json) -> None:
        """Show a figure; there is no plot before there are data: an empty one takes a browser as long to draw."""
        if name in self.plots:
            self.plots[name].update_figure(figure)
        elif not figure["data"]:
            if name == FIRST:
                self.hint.text = WITHOUT_MODEL if self.desk.records else WITHOUT_DATA
        else:
            place, words = self.places[name]
            place.clear()
            with place:
                made = ui.plotly(figure).classes("w-full")
            made.props(f'role="figure" aria-label="{words}"')
            self.plots[name] = made
            if name == FIRST:
                made.on("plotly_afterplot", self._drawn, [])
                made.on(
                    "plotly_relayout",
                    self._moved,
                    ["xaxis.range[0]", "xaxis.range[1]", "xaxis.autorange"],
                )
                made.on("plotly_selected", self.safely(self._dragged), ["range"])
            elif name == "map":
                made.on("plotly_click", self._clicked, ["points"])

    @property
    def following(self) -> LiveDesk | None:
        """The desk of the running graph that the plots show; None where they show what was opened."""
        return self.live if self.live is not None and self.live.follow else None

    def _follow(self) -> None:
        """Draw what the graph said since the last turn; the error's course wherever one looks."""
        desk, turn = self.live, self.turn
        self.turn += 1
        if desk is None:
            return
        if self.tabs.value == "Live":
            self.panels["Live"].refresh()
        for name, (make, every) in LIVE.items():
            if turn % every == 0 and (desk.follow or name == "error"):
                self._put(name, make(desk.heard, self.theme))

    def follow(self, *, on: bool) -> None:
        """Show the running graph, or what was opened."""
        if self.live is not None:
            self.live.follow, self.turn = on, 0
            self.live.changed()

    def _header(self) -> None:
        desk = self.desk
        with ui.header().classes("items-center gap-2 py-1"):
            ui.label("Model lab").classes("text-lg font-bold").props("role=heading aria-level=1")
            self.model = ui.label("no model")
            self.error = ui.label("").classes("numbers").props("role=status aria-live=polite")
            helped(self.error, "learnt from", "held out")
            ui.space()
            self.undo = _button("undo", "Undo (Ctrl Z)", self.safely(desk.undo))
            self.redo = _button("redo", "Redo (Ctrl Y)", self.safely(desk.redo))
            self.fitted = _button("settings_backup_restore", "Back to fitted", self.safely(
                lambda: desk.take(desk.now.as_fitted())
            ))  # fmt: skip
            _button("help_outline", "Words of the lab", show_all)
            _button("contrast", "Light or dark", self._shade)

    def _panels(self) -> None:
        makers: dict[str, Callable[[Host], Panel]] = {
            **({"Live": LivePanel} if self.live is not None else {}),
            "Data": DataPanel,
            "Play": PlayPanel,
            "Learn": LearnPanel,
            "Steps": StepsPanel,
            "Take": TakePanel,
        }
        self.tabs = ui.tabs()
        with self.tabs.props("dense no-caps inline-label").classes("w-full"):
            for name in makers:
                ui.tab(name)
        self.panels: dict[str, Panel] = {}
        with ui.tab_panels(self.tabs, value=self._first(), keep_alive=False).classes("w-full"):
            for name, maker in makers.items():
                with ui.tab_panel(name).classes("p-1"):
                    self.panels[name] = maker(self)

    def _first(self) -> str:
        """The panel that is open at first."""
        if self.live is not None:
            return "Live"
        return "Data" if self.desk.sight is None else "Play"

    def _views(self) -> None:
        if self.live is not None:
            self._place("error", "Live error over the drive, and what happened")
        with ui.row().classes("wide items-center gap-1"):
            if self.live is not None:
                ui.switch(
                    "follow the drive", value=self.live.follow, on_change=lambda e: self.follow(on=bool(e.value))
                )  # fmt: skip
            else:
                said = ui.label("Drag over the curves, click a tile of the map.").classes("muted")
                helped(said, "residual", "residual map", "spectrum")
            ui.switch("dragging holds out", on_change=lambda e: self.hold(on=bool(e.value))).props(
                "dense"
            ).tooltip(
                "Drag over the curves: that stretch only scores, and nothing is learnt from it"
            )
            ui.space()
            self.second = ui.label("").classes("numbers text-sm").props("role=status")
            self.beside = ui.select([], label="Lay another model beside", on_change=self.safely(
                lambda e: self.desk.lay(e.value)
            )).props('dense options-dense clearable aria-label="Lay another model beside"').classes("w-40")  # fmt: skip
            for icon, words, by in (
                ("chevron_left", "Earlier", -0.5),
                ("chevron_right", "Later", 0.5),
            ):
                _button(icon, words, lambda by=by: self._move(by))
            _button("zoom_in", "Closer", lambda: self._zoom(0.5))
            _button("zoom_out", "Wider", lambda: self._zoom(2.0))
            _button("select_all", "Show all (Escape)", self.show_all)
        for name, (_, words) in PLOTS.items():
            self._place(name, words)

    def _place(self, name: str, words: str) -> None:
        """Where a plot comes as soon as there is something to draw; words: for who cannot see it."""
        place = ui.element("div").classes("wide" if name in HEIGHTS else "")
        with place.style(f"min-height: {HEIGHTS.get(name, HEIGHT)}px"):
            if name == FIRST:
                self.hint = ui.label().classes("muted p-4").props("role=status")
        self.places[name] = place, words

    def select(self, selection: Selection) -> None:
        """Show a selection everywhere."""
        self.desk.selection = selection
        self.desk.changed()
        self.look()

    def hold(self, *, on: bool) -> None:
        """Whether what is dragged over is held out, else looked at."""
        self.holding, self.seen = on, -1
        self.look()

    def _dragged(self, event: GenericEventArguments) -> None:
        """A stretch was dragged over to be held out."""
        span = ((event.args or {}).get("range") or {}).get("x")
        if self.holding and self.following is None and span:
            self.seen = -1
            self.desk.hold_between(*sorted(float(t) for t in span))

    def show_all(self) -> None:
        """Take the selection away."""
        self.select(Selection())

    def _moved(self, event: GenericEventArguments) -> None:
        """The curves were zoomed: the seconds in view are selected."""
        if self.following is not None:
            return
        low, high = event.args.get("xaxis.range[0]"), event.args.get("xaxis.range[1]")
        at = self.desk.selection
        if event.args.get("xaxis.autorange"):
            self.select(Selection(None, at.velocity, at.deflection))
        elif isinstance(low, int | float) and isinstance(high, int | float) and low < high:
            self.select(Selection((float(low), float(high)), at.velocity, at.deflection))

    def _clicked(self, event: GenericEventArguments) -> None:
        """A tile was clicked: its samples are selected, or all again."""
        sight, at = self.desk.sight, self.desk.selection
        points = event.args.get("points") or []
        if sight is None or not points or self.following is not None:
            return
        found = tile_at(sight, 1e-3 * float(points[0]["x"]), 1e-3 * float(points[0]["y"]))
        same = found.velocity == at.velocity and found.deflection == at.deflection
        self.select(
            Selection(at.seconds)
            if same
            else Selection(at.seconds, found.velocity, found.deflection)
        )

    def _window(self) -> tuple[float, float]:
        sight = self.desk.sight
        whole = (0.0, 1.0) if sight is None else sight.ends
        return self.desk.selection.seconds or whole

    def _move(self, by: float) -> None:
        a, b = self._window()
        self._seconds(a + by * (b - a), b + by * (b - a))

    def _zoom(self, by: float) -> None:
        a, b = self._window()
        self._seconds(0.5 * (a + b) - 0.5 * by * (b - a), 0.5 * (a + b) + 0.5 * by * (b - a))

    def _seconds(self, a: float, b: float) -> None:
        sight, at = self.desk.sight, self.desk.selection
        if sight is not None and b - a >= 4 * sight.problem.motion.dt:
            low, high = sight.ends
            a, b = max(a, low), min(b, high)
            whole = (a, b) == (low, high) or a >= b
            self.select(Selection(None if whole else (a, b), at.velocity, at.deflection))

    def _laid(self) -> str:
        """The error of the model that is laid beside."""
        model = self.desk.choice.get(self.desk.beside)
        errors = None if model is None else self.desk.errors(model)
        return "" if model is None else f"beside: {errors or 'no prediction along this motion'}"

    def _offer(self) -> None:
        """Which models may be laid beside."""
        every = list(dict.fromkeys([*self.desk.choice, *names("dampers")]))
        if every != self.beside.options:
            self.beside.set_options(
                every, value=self.desk.beside if self.desk.beside in every else None
            )

    async def _as_system(self) -> None:
        """Light or dark as the system of the browser is."""
        dark = 'matchMedia("(prefers-color-scheme: dark)").matches'
        self.shade(dark=bool(await ui.run_javascript(dark, timeout=10.0)))

    def _shade(self) -> None:
        self.shade(dark=self.theme is plots.LIGHT)

    def shade(self, *, dark: bool) -> None:
        """Light or dark; what is drawn so already stays."""
        # an element for it would have the browser style the whole page anew with every update
        ui.run_javascript(f"setDark({str(dark).lower()})")
        theme = plots.DARK if dark else plots.LIGHT
        if theme is not self.theme:
            self.theme, self.seen = theme, -1
            self.told.clear()

    def _key(self, event: Any) -> None:
        """Keys beside those of the widgets."""
        if not event.action.keydown:
            return
        if event.modifiers.ctrl and event.key == "z":
            ui.timer(0, self.safely(self.desk.undo), once=True)
        elif event.modifiers.ctrl and event.key == "y":
            ui.timer(0, self.safely(self.desk.redo), once=True)
        elif event.key == "Escape":
            self.show_all()


def _button(icon: str, words: str, action: Callable[..., Any]) -> ui.button:
    """A round button with its words for the mouse and for screen readers."""
    made = ui.button(icon=icon, on_click=action).props(
        f'flat round dense color=inherit aria-label="{words}"'
    )
    return made.tooltip(words)
