"""`lab open`: the lab in a browser of this machine."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated

import typer
from er_common.port import HOST, free_port
from er_models.errors import ErError, InputError

from er_model_lab.cli.options import EffectsFrom, Seed
from er_model_lab.cli.running import fail

if TYPE_CHECKING:
    from er_model_lab.session.desk import Desk


def open_command(
    data: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[DATA ...]",
            help="Measurements to begin with; with --live the namespace of a graph.",
        ),
    ] = None,
    model: Annotated[
        str | None,
        typer.Option("--model", help="Model to begin with: a file, or the name of a shipped one."),
    ] = None,
    port: Annotated[
        int | None, typer.Option("--port", help="Port of 127.0.0.1; by default a free one.")
    ] = None,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Only print the address.")
    ] = False,
    live: Annotated[
        bool,
        typer.Option(
            "--live", help="Follow the running graph in the namespace that is named, or in none."
        ),
    ] = False,
    minutes: Annotated[
        float,
        typer.Option(
            "--minutes", min=1.0, max=60.0, help="How much of a drive is remembered (--live)."
        ),
    ] = 5.0,
    allow_code: Annotated[
        bool,
        typer.Option(
            "--allow-code",
            help="Let Python files with effects that are dropped run, with your rights.",
        ),
    ] = False,
    effects_from: EffectsFrom = None,
    seed: Seed = 0,
) -> None:
    """The lab as a page: look, play, learn, add, take away. The last line is its address; Ctrl-C ends it."""
    try:
        with TemporaryDirectory(prefix="er_lab_") as folder:
            free, begun = free_port(port), effects_from or []
            if live:
                desk = _beside(Path(folder), data or [], minutes, seed)
            else:
                desk = _over(Path(folder), data or [], seed, allow_code)
            desk.code_files = tuple(begun)
            _serve(desk, data if data and not live else [], model, free, browser=not no_browser)
    except KeyboardInterrupt:  # how a page is ended
        return
    except ErError as error:
        fail(error)


def _over(folder: Path, data: list[Path], seed: int, code: bool) -> Desk:
    from er_model_lab.session.desk import Desk

    for path in data:
        if not path.exists():
            raise InputError(path, "", "a file or folder", "nothing there")
    return Desk(folder, given=data, seed=seed, code=code)


def _beside(folder: Path, names: list[Path], minutes: float, seed: int) -> Desk:
    from er_model_lab.session.live_desk import LiveDesk

    if len(names) > 1:
        raise InputError("--live", "", "one namespace, or none", " ".join(map(str, names)))
    return LiveDesk(folder, str(names[0]) if names else "", minutes=minutes, seed=seed)


def _serve(desk: Desk, data: list[Path], model: str | None, port: int, *, browser: bool) -> None:
    from er_common.extras import extra

    from er_model_lab.session.steps import Source
    from er_model_lab.verbs.load import load_model

    begun = load_model(model, desk.code_files) if model else None
    with extra("er_model_lab[page]", "the page"):
        from er_model_lab.page.server import serve
    if data or begun:
        desk.bring([Source(path) for path in data], begun, str(model or ""))
    serve(desk, host=HOST, port=port, browser=browser, say=typer.echo)
