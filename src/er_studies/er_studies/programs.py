"""Commands of several parts, each a program of its own: what one part needs, no other waits for."""

from __future__ import annotations

import runpy
import signal
import sys
from collections.abc import Callable, Mapping

import typer
from er_common.usage import OneLineCommand
from er_models.errors import ErError
from er_models.one_line import INTERRUPTED


def hand_over(command: str, parts: Mapping[str, str], text: str) -> None:
    """Run the part that the first argument names; ends the program without one.

    command: as it is typed; parts: name to module; text: what there is, for whoever names nothing. SIGTERM does what
    Ctrl-C does: a part ends the processes that it began.
    """
    name = sys.argv[1] if len(sys.argv) > 1 else ""
    if name in ("", "-h", "--help"):
        sys.stdout.write(text + "\n")
        sys.exit(0)
    if name not in parts:
        sys.stderr.write(f"{command}: expected one of {', '.join(parts)}, found '{name}'\n")
        sys.exit(2)
    sys.argv = [f"{command} {name}", *sys.argv[2:]]
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        runpy.run_module(parts[name], run_name="__main__")
    except KeyboardInterrupt:
        sys.stderr.write(f"{sys.argv[0]}: interrupted\n")
        sys.exit(INTERRUPTED)


def program_of(command: Callable[..., None]) -> typer.Typer:
    """A program that is one command; a wrong usage is one line."""
    app = typer.Typer(
        add_completion=False,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.command(cls=OneLineCommand)(command)
    return app


def run(app: typer.Typer) -> None:
    """Run a program under the name it was called by; an error of the user is one line."""
    try:
        app(prog_name=sys.argv[0])
    except ErError as error:
        sys.stderr.write(f"{sys.argv[0]}: {error}\n")
        sys.exit(error.exit_status)
