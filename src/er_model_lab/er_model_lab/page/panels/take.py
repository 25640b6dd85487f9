"""Take away: model, program, session, report, series, unit for co-simulation."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from er_models.errors import InputError
from er_models.program import save_program
from nicegui import ui

from er_model_lab.page.panels.panel import Host
from er_model_lab.session.desk import Desk
from er_model_lab.session.kept import model_text, packed
from er_model_lab.session.script import alone


def _model(desk: Desk, _: Path) -> bytes:
    return model_text(desk.now.known).encode()


def _script(desk: Desk, _: Path) -> bytes:
    return alone(desk.session, desk.folder).encode()


def _session(desk: Desk, _: Path) -> bytes:
    return packed(desk.session, desk.folder)


def _report(desk: Desk, folder: Path) -> bytes:
    from er_model_lab.verbs.compare import compare

    result = desk.result or compare(desk.data, desk.now.known, seed=desk.session.seed, anyway=True)
    return result.report(folder).read_bytes()


def _series(desk: Desk, folder: Path) -> bytes:
    from er_model_lab.verbs.export import export

    files = export(desk.now.known, desk.data, series=folder / "series.csv", anyway=True).files
    return b"".join(f"# {f.stem}\n".encode() * (len(files) > 1) + f.read_bytes() for f in files)


def _run(desk: Desk, folder: Path) -> bytes:
    if desk.planned is None or desk.planned.program is None:
        raise InputError("run", "", "a run that was planned: diagnose, then plan", "none yet")
    save_program(desk.planned.program, folder / "run.yaml")
    return (folder / "run.yaml").read_bytes()


def _fmu(desk: Desk, folder: Path) -> bytes:
    from er_model_lab.verbs.export import export

    return export(desk.now.known, fmu=folder / "damper.fmu").files[0].read_bytes()


THINGS: dict[str, tuple[str, Callable[[Desk, Path], bytes]]] = {
    "Model": ("model.yaml", _model), "Program": ("session.py", _script), "Session": ("session.zip", _session),
    "Report": ("report.html", _report), "Series": ("series.csv", _series),
    "FMU": ("damper.fmu", _fmu), "Run": ("run.yaml", _run),
}  # fmt: skip
"""What can be taken: the name of the file, and what writes it."""
HELP = {
    "Model": "the model file that every command of the lab reads",
    "Program": "a Python program that does what you did, and makes the same model",
    "Session": "program, data and all steps; drop it here to go on",
    "Report": "a page that opens offline: of the last diagnosis, else of how the model compares",
    "Series": "time, inputs, measured and predicted force, the share of each effect",
    "Run": "the planned run: road and duty, as a program for the rig or the graph",
    "FMU": "a unit for co-simulation (FMI 3)",
}


class TakePanel:
    """A button for each thing."""

    def __init__(self, host: Host) -> None:
        self.host = host
        for name, words in HELP.items():
            with ui.row().classes("w-full items-center no-wrap"):
                ui.button(name, on_click=host.safely(lambda name=name: self._take(name))).classes(
                    "w-28 shrink-0"
                ).props("no-caps")
                ui.label(words).classes("text-sm")

    def refresh(self) -> None:
        """Nothing here changes."""

    async def _take(self, name: str) -> None:
        file, make = THINGS[name]
        if self.host.desk.now.model is None:
            raise InputError(name, "", "a model", "none yet")
        ui.notify(f"writing {file} ...")
        ui.download.content(await asyncio.to_thread(_made, make, self.host.desk), file)


def _made(make: Callable[[Desk, Path], bytes], desk: Desk) -> bytes:
    with TemporaryDirectory(prefix="er_lab_") as folder:
        return make(desk, Path(folder))
