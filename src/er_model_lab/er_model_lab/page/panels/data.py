"""Data: drop files, say what their columns are, see what is wrong with them, and hold some of them out."""

from __future__ import annotations

import asyncio
from itertools import cycle
from pathlib import Path
from typing import Any

from er_models.errors import ErError, InputError
from er_models.own import effects
from er_models.shipped import MODELS, names
from nicegui import ui
from nicegui.events import GenericEventArguments, UploadEventArguments

from er_model_lab.fitting.kinds import KINDS
from er_model_lab.output.text.units import percent
from er_model_lab.page.panels.help import heading
from er_model_lab.page.panels.mapping import MappingDialog
from er_model_lab.page.panels.panel import Host
from er_model_lab.preflight.finding import Finding
from er_model_lab.session import dropped
from er_model_lab.session.desk import with_source
from er_model_lab.session.kept import unpacked
from er_model_lab.session.sight import Selection, worst
from er_model_lab.session.steps import Source, Stretch

DROP = "Drop measurements, a model or a session"
HEADER = f"""<div class="row items-center no-wrap q-pa-sm">
<label class="col relative-position q-pa-sm text-weight-bold">{DROP}<q-uploader-add-trigger /></label>
<q-btn flat round dense icon="add" aria-label="Choose files" @click="props.pickFiles" /></div>"""
"""The framework's own head has a button within which lies an input that no screen reader can name."""
BESIDE = 0.5
"""Least time that is shown beside a place [s]."""
FINDINGS = {"fail": "fail", "warning": "warning", "note": "muted"}
"""Levels of findings that are shown, and their look."""


class DataPanel:
    """Files, model, records, findings, worst places."""

    def __init__(self, host: Host) -> None:
        self.host, desk = host, host.desk
        self.upload = ui.upload(
            multiple=True, auto_upload=True, max_file_size=dropped.LARGEST, label=DROP,
            on_upload=host.safely(self._dropped),
            on_rejected=lambda: ui.notify(f"more than {dropped.LARGEST >> 30} GB"),
        )  # fmt: skip
        self.upload.props("flat bordered no-thumbnails").add_slot("header", HEADER)
        self.upload.on("added", self._announced, js_handler="f => emit(f.map(each => each.name))")
        self.upload.on("finish", self._sent, args=[])
        shipped = [n for n in names(*MODELS) if n in names("dampers")]
        self.model = ui.select(
            shipped, label="Begin with a shipped model", on_change=host.safely(lambda e: self._start(e.value))
        ).classes("w-full").props('dense options-dense aria-label="Begin with a shipped model"')  # fmt: skip
        kinds = {kind: f"{kind}: {found.title}" for kind, found in KINDS.items()}
        ui.select(
            kinds,
            label="New model, scaled to the data",
            on_change=host.safely(lambda e: desk.new(e.value)),
        ).classes("w-full").props('dense options-dense aria-label="New model, scaled to the data"')
        self.progress = ui.label("").classes("muted").props("role=status")
        self.records = ui.column().classes("w-full gap-0")
        ui.button("Hold out what is in view", on_click=host.safely(self._hold_view)).props(
            "flat dense no-caps"
        )
        heading("Worst places", "worst places")
        self.worst = ui.column().classes("w-full gap-0")
        heading("Findings", "findings", "held out")
        self.findings = ui.column().classes("w-full gap-1")
        self.shown: object = None
        self.desk = desk
        self.turns, self.coming = asyncio.Condition(), dict[str, bool]()
        self.said: dict[tuple[str, ...], dict[str, Any]] = {}

    def refresh(self) -> None:
        """Show what there is."""
        desk, job = self.desk, self.desk.jobs.job
        opening = job is not None and job.title == "open the data"
        self.progress.text = (
            ("reading and checking ..." if job and job.running else job.error if job else "")
            if opening
            else ""
        )
        key = (id(desk.sight), desk.now.held, id(desk.records))
        if key != self.shown:
            self.shown = key
            self._records()
            self._findings()
        self._worst()

    def _records(self) -> None:
        held = {s.record for s in self.desk.now.held if s.start == 0.0 and s.end > 1e9}
        self.records.clear()
        with self.records:
            for k, record in enumerate(self.desk.records):
                seconds = float(record.t[-1] - record.t[0])
                with ui.row().classes("w-full items-center justify-between no-wrap"):
                    ui.label(f"{record.name}, {seconds:.4g} s").classes("ellipsis")
                    act = self.host.safely(lambda e, k=k: self._hold(k, on=e.value))
                    ui.checkbox("only scores", value=k in held, on_change=act).props("dense")
            for stretch in self.desk.now.held:
                if stretch.end < 1e9:
                    self._stretch(stretch)
            if self.desk.now.held:
                ui.button(
                    "Hold nothing out by hand",
                    on_click=self.host.safely(lambda: self.desk.hold(())),
                ).props("flat dense no-caps")

    def _stretch(self, held: Stretch) -> None:
        """A part of a record that is held out, and its end."""
        name = self.desk.records[held.record].name
        words = f"held out: {name}, {held.start:.3g} to {held.end:.3g} s"
        others = tuple(s for s in self.desk.now.held if s != held)
        with ui.row().classes("w-full items-center justify-between no-wrap"):
            ui.label(words).classes("ellipsis")
            act = self.host.safely(lambda: self.desk.hold(others))
            ui.button(icon="close", on_click=act).props(
                f'flat round dense size=sm aria-label="Not any more {words}"'
            ).tooltip("learn from it again")

    def _findings(self) -> None:
        self.findings.clear()
        found = [] if self.desk.sight is None else list(self.desk.sight.preflight.findings)
        alike: dict[tuple[object, ...], list[Finding]] = {}
        for f in (f for f in found if f.level in FINDINGS):
            own = f.record if f.spans else ""  # places of their own are shown one by one
            alike.setdefault((f.level, f.check, f.channel, f.found, own), []).append(f)
        with self.findings:
            for f, *more in alike.values():
                where = f"{len(more) + 1} records" if more else f.record
                text = f"{f.level}: {f.channel or f.check} of {where}: {f.found}".replace("_", " ")
                self._finding(f, text)
                if f.remedy:
                    ui.label(f.remedy).classes("text-xs muted pl-4")
            if not any(f.level in FINDINGS for f in found):
                ui.label("nothing is wrong" if found else "nothing checked yet").classes("muted")

    def _finding(self, finding: Finding, text: str) -> None:
        """Its words; where it has places, a button that goes from one to the next."""
        sight, look = self.desk.sight, f"text-sm {FINDINGS[finding.level]}"
        places = [] if sight is None else sight.places(finding)
        if not places:
            ui.label(text).classes(look)
            return
        turn = cycle(places)
        go = self.host.safely(lambda: self._show(Selection(seconds=next(turn))))
        ui.button(text, on_click=go).props("flat dense no-caps align=left color=none").classes(
            f"{look} finding w-full"
        ).tooltip(f"show it, and the next of {len(places)}" if len(places) > 1 else "show it")

    def _worst(self) -> None:
        sight, residual = self.desk.sight, self.desk.residual
        self.worst.clear()
        with self.worst:
            for place in (
                worst(sight, residual) if sight is not None and residual is not None else []
            ):
                show = self.host.safely(lambda at=place.selection: self._show(at))
                ui.button(f"{percent(place.share)}: {place.says}", on_click=show).props(
                    "flat dense no-caps align=left"
                )

    def _show(self, at: Selection) -> None:
        """Go to a place, with some seconds around it."""
        if at.seconds is not None:
            a, b = at.seconds
            more = max(0.5 * (b - a), BESIDE)
            at = Selection((max(a - more, 0.0), b + more))
        self.host.select(at)

    def _hold(self, record: int, *, on: bool) -> None:
        others = tuple(s for s in self.desk.now.held if s.record != record)
        self.desk.hold((*others, Stretch(record)) if on else others)

    def _hold_view(self) -> None:
        seconds = self.desk.selection.seconds
        if seconds is None:
            raise InputError(
                "held_out", "", "a stretch in view: drag over the curves first", "all of the data"
            )
        self.desk.hold_between(*seconds)

    def _start(self, name: str) -> None:
        from er_model_lab.verbs.load import load_model

        self.desk.bring(self.desk.now.sources, load_model(name, self.desk.code_files), name)

    async def _dropped(self, event: UploadEventArguments) -> None:
        """Keep a file that was dropped, and do with it what belongs to its kind."""
        desk, name = self.desk, event.file.name
        self.coming[name], path = True, None
        try:
            kind = desk.admitted(name, event.file.size())
            path = dropped.place_for(desk.folder, name)
            await event.file.save(path)
            async with self.turns:
                await self.turns.wait_for(
                    lambda: name in [*self.coming][:1] or name not in self.coming
                )
                await self._take(kind, path)
        except ErError:
            if path is not None:
                path.unlink(missing_ok=True)
            raise
        finally:
            await self._settled(name)

    def _announced(self, event: GenericEventArguments) -> None:
        """Files that come together arrive in any order: the browser says in which the user gave them."""
        for name in event.args:
            self.coming.setdefault(name, False)

    async def _sent(self) -> None:
        """A file that the browser could not send keeps no other waiting."""
        for name in [n for n, arrived in self.coming.items() if not arrived]:
            ui.notify(f"{name}: did not arrive", type="negative")
            await self._settled(name)

    async def _settled(self, name: str) -> None:
        """The next file's turn."""
        async with self.turns:
            self.coming.pop(name, None)
            if not self.coming:  # what comes later is asked for anew: an answer may be mended
                self.said.clear()
                self.upload.reset()  # it refuses a file that stands in its list
            self.turns.notify_all()

    async def _take(self, kind: str, path: Path) -> None:
        desk = self.desk
        if kind == "code":
            await asyncio.to_thread(effects, [*desk.code_files, path])
            desk.code_files = (*desk.code_files, path)
            ui.notify(f"{path.name}: models that you begin with from now on may have its effects")
        elif kind == "zip" and not dropped.is_session(path):
            for each in await asyncio.to_thread(dropped.measurements_of, path, desk.folder):
                await self._measured(each)
            path.unlink()
        elif kind == "zip":
            given = (*desk.given, *desk.code_files)
            session = await asyncio.to_thread(unpacked, path, desk.folder, given, code=desk.code)
            path.unlink()
            own = session.code
            desk.code_files = (*desk.code_files, *(p for p in own if p not in desk.code_files))
            desk.go(session)
        elif kind == "model":
            model = dropped.model_of(path, desk.code_files)
            desk.bring(desk.now.sources, model, str(path))
        else:
            await self._measured(path)

    async def _measured(self, path: Path) -> None:
        """Ask what the columns are where they do not say so themselves; once for files that come together."""
        from er_model_lab.verbs.map import map as mapped

        found = await asyncio.to_thread(mapped, path)
        headers = tuple(s.header for s in found.survey.columns)
        said = self.said.get(headers)
        if said is not None:
            found = await asyncio.to_thread(mapped, path, said)
            ui.notify(f"{path.name}: read as the file before with these columns")
        if found.trouble or (said is None and not found.needless):
            said = await MappingDialog(path, found).asked()
            if said is None:
                path.unlink()
                ui.notify(f"{path.name}: left out")
                return
            self.said[headers] = said
        self.desk.bring(with_source(self.desk.now, Source(path, said)))
        await asyncio.to_thread(self.desk.jobs.wait)
