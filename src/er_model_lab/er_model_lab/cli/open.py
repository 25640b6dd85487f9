"""`lab open`: the lab in a browser of this machine."""

from __future__ import annotations

import socket
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer
from er_models.errors import ErError, InputError

from er_model_lab.cli.options import EffectsFrom, Seed
from er_model_lab.cli.running import fail

HOST = "127.0.0.1"
"""The only address that the page is served at."""


def open_command(
    data: Annotated[
        list[Path] | None, typer.Argument(metavar="[DATA ...]", help="Measurements to begin with.")
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
            _serve(
                Path(folder),
                data or [],
                model,
                port,
                not no_browser,
                allow_code,
                effects_from or [],
                seed,
            )
    except KeyboardInterrupt:  # how a page is ended
        return
    except ErError as error:
        fail(error)


def _free(asked: int | None) -> int:
    """A port of this machine: the one asked for, else any.

    Raises:
        InputError: It is in use, or not allowed.
    """
    with socket.socket() as found:
        try:
            found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            found.bind((HOST, asked or 0))
        except (OSError, OverflowError) as error:
            raise InputError("--port", "", "a port that is free", f"{asked}: {error}") from None
        return int(found.getsockname()[1])


def _serve(
    folder: Path, data: list[Path], model: str | None, port: int | None, browser: bool, code: bool,
    effects_from: list[Path], seed: int,
) -> None:  # fmt: skip
    free = _free(port)
    from er_common.extras import extra

    from er_model_lab.session.desk import Desk
    from er_model_lab.session.steps import Source
    from er_model_lab.verbs.load import load_model

    for path in data:
        if not path.exists():
            raise InputError(path, "", "a file or folder", "nothing there")
    begun = load_model(model, effects_from) if model else None
    with extra("er_model_lab[page]", "the page"):
        from er_model_lab.page.server import serve

    desk = Desk(folder, given=data, seed=seed, code=code)
    desk.code_files = tuple(effects_from)
    if data or begun:
        desk.bring([Source(path) for path in data], begun, str(model or ""))
    serve(desk, host=HOST, port=free, browser=browser, say=lambda address: typer.echo(address))
