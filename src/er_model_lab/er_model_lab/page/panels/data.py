"""Data: drop files, say what their columns are, see what is wrong with them, and hold some of them out."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

from er_models.errors import ErError, InputError
from er_models.shipped import MODELS, names
from nicegui import ui
from nicegui.events import UploadEventArguments

from er_model_lab.output.text.units import percent
from er_model_lab.page.panels.mapping import MappingDialog
from er_model_lab.page.panels.panel import Host
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
FINDINGS = {"fail": "fail", "warning": "warning", "note": "muted"}
"""Levels of findings that are shown, and their look."""


class DataPanel:
    """Files, model, records, findings, worst places."""

    def __init__(self, host: Host) -> None:
        self.host, desk = host, host.desk
        upload = ui.upload(
            multiple=True, auto_upload=True, max_file_size=dropped.LARGEST, label=DROP,
            on_upload=host.safely(self._dropped),
            on_rejected=lambda: ui.notify(f"more than {dropped.LARGEST >> 30} GB"),
        )  # fmt: skip
        upload.props("flat bordered no-thumbnails").add_slot("header", HEADER)
        shipped = [n for n in names(*MODELS) if n in names("dampers")]
        self.model = ui.select(
            shipped, label="Begin with a shipped model", on_change=host.safely(lambda e: self._start(e.value))
        ).classes("w-full").props('dense options-dense aria-label="Begin with a shipped model"')  # fmt: skip
        self.progress = ui.label("").classes("muted").props("role=status")
        self.records = ui.column().classes("w-full gap-0")
        ui.button("Hold out what is in view", on_click=host.safely(self._hold_view)).props(
            "flat dense no-caps"
        )
        ui.label("Worst places").classes("font-bold").props("role=heading aria-level=2")
        self.worst = ui.column().classes("w-full gap-0")
        ui.label("Findings").classes("font-bold").props("role=heading aria-level=2")
        self.findings = ui.column().classes("w-full gap-1")
        self.shown: object = None
        self.desk = desk

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
                    ui.label(
                        f"held out: record {stretch.record + 1}, {stretch.start:.4g} to {stretch.end:.4g} s"
                    )
            if self.desk.now.held:
                ui.button(
                    "Hold nothing out by hand",
                    on_click=self.host.safely(lambda: self.desk.hold(())),
                ).props("flat dense no-caps")

    def _findings(self) -> None:
        self.findings.clear()
        found = [] if self.desk.sight is None else list(self.desk.sight.preflight.findings)
        with self.findings:
            for f in (f for f in found if f.level in FINDINGS):
                text = f"{f.level}: {f.channel or f.check} of {f.record}: {f.found}"
                ui.label(text.replace("_", " ")).classes(f"text-sm {FINDINGS[f.level]}")
                if f.remedy:
                    ui.label(f.remedy).classes("text-xs muted pl-4")
            if not any(f.level in FINDINGS for f in found):
                ui.label("nothing is wrong" if found else "no data yet").classes("muted")

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
        """Go to a worst place, with some seconds around it."""
        if at.seconds is not None:
            a, b = at.seconds
            at = Selection((max(a - 0.5 * (b - a), 0.0), b + 0.5 * (b - a)))
        self.host.select(at)

    def _hold(self, record: int, *, on: bool) -> None:
        others = tuple(s for s in self.desk.now.held if s.record != record)
        self.desk.hold((*others, Stretch(record)) if on else others)

    def _hold_view(self) -> None:
        sight, seconds = self.desk.sight, self.desk.selection.seconds
        if sight is None or seconds is None:
            raise InputError(
                "held_out", "", "a stretch in view: drag over the curves first", "all of the data"
            )
        names_of = [r.name for r in self.desk.records]
        new = [
            Stretch(names_of.index(name), max(seconds[0] - a, 0.0), seconds[1] - a)
            for name, a, b in sight.spans if name in names_of and seconds[0] < b and seconds[1] > a
        ]  # fmt: skip
        if not new:
            raise InputError(
                "held_out", "", "a stretch of a whole record", "a part that is held out already"
            )
        self.desk.hold((*self.desk.now.held, *new))

    def _start(self, name: str) -> None:
        from er_model_lab.verbs.load import load_model

        self.desk.bring(self.desk.now.sources, load_model(name, self.desk.code_files), name)

    async def _dropped(self, event: UploadEventArguments) -> None:
        """Keep a file that was dropped, and do with it what belongs to its kind."""
        desk, name = self.desk, event.file.name
        kind = dropped.kind_of(name, code=desk.code)
        if event.file.size() > min(dropped.LARGEST, desk.room()):
            raise InputError(
                name,
                "",
                f"at most {dropped.LARGEST >> 30} GB, all files {desk.room() >> 20} MB",
                "more",
            )
        path = dropped.place_for(desk.folder, name)
        await event.file.save(path)
        try:
            await self._take(kind, path)
        except ErError:
            path.unlink(missing_ok=True)
            raise

    async def _take(self, kind: str, path: Path) -> None:
        desk = self.desk
        if kind == "code":
            desk.code_files = (*desk.code_files, path)
        elif kind == "session":
            session = await asyncio.to_thread(unpacked, path, desk.folder, desk.given)
            path.unlink()
            desk.go(session)
        elif kind == "model":
            model = dropped.model_of(path, desk.code_files)
            desk.bring(desk.now.sources, model, str(path))
        else:
            await self._measured(path)

    async def _measured(self, path: Path) -> None:
        """Ask what the columns are where they do not say so themselves."""
        from er_model_lab.verbs.map import map as mapped

        found = await asyncio.to_thread(mapped, path)
        said: Any = None
        if not found.needless or found.trouble:
            said = await MappingDialog(path, found).asked()
            if said is None:
                raise InputError(path.name, "", "columns that are known", "no answer")
        self.desk.bring(with_source(self.desk.now, Source(path, said)))
