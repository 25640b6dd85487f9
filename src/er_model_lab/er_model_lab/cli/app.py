"""Command line of the model lab: `er lab COMMAND`, or `er-lab COMMAND`."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable
from typing import ClassVar

import typer
from er_common.command_line import by_er
from er_common.usage import OneLineGroup
from er_models.one_line import INTERRUPTED

from er_model_lab.cli.data import check_command, compare_command, identify_command
from er_model_lab.cli.export import export_command
from er_model_lab.cli.fleet import fleet_command
from er_model_lab.cli.mapping import map_command
from er_model_lab.cli.missing import add_command, diagnose_command, improve_command
from er_model_lab.cli.open import open_command
from er_model_lab.cli.plan import effects_command, plan_command
from er_model_lab.cli.start import models_command, new_command

COMMANDS: dict[str, tuple[Callable[..., None], str]] = {
    "map": (map_command, "Say what the columns of your own files are."),
    "new": (new_command, "Begin a model of a kind, scaled to your data."),
    "models": (models_command, "Kinds of start models, and what is shipped."),
    "check": (check_command, "Check measurements before anything is fitted."),
    "compare": (compare_command, "Say where a model fails; several side by side."),
    "diagnose": (diagnose_command, "Say which effect is missing, with evidence."),
    "add": (add_command, "Add one effect and refit everything."),
    "improve": (improve_command, "Diagnose and add until nothing is missing."),
    "plan": (plan_command, "Plan the run that tells two effects apart."),
    "identify": (identify_command, "Identify every parameter in stages."),
    "fleet": (fleet_command, "Diagnose many dampers; say which differ, and since when."),
    "export": (export_command, "A model as series, table, C code or FMU."),
    "open": (open_command, "The lab in a browser."),
    "effects": (effects_command, "The catalogue of effects, or one effect's card."),
}
"""In the order in which they are used, with one line each that fits a terminal."""
WAIT = 1.0
"""Longest wait for threads and processes after Ctrl-C [s]."""


class _Lab(OneLineGroup):
    """The lab's commands."""

    moved: ClassVar = {"thesis": "./er study thesis", "import": "./er study import"}


app = typer.Typer(
    cls=_Lab,
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Compare a damper model with measurements, find the missing effect, add it, watch the error fall.",
)
for name, (command, line) in COMMANDS.items():
    app.command(name, short_help=line)(command)


def main() -> None:
    """Entry point; who asks to end (SIGTERM) gets what Ctrl-C gives: what was done is kept."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        app(prog_name="./er lab" if by_er() else None)
    except SystemExit as end:
        if end.code == INTERRUPTED:
            _end_soon()
        raise


def _end_soon() -> None:
    """End this process before long: Python waits for every thread, which may be in the middle of a long fit."""
    from er_model_lab.jobs.processes import PROCESSES

    sys.stdout.flush()
    last = threading.Timer(WAIT, os._exit, (INTERRUPTED,))
    last.daemon = True
    last.start()
    PROCESSES.shutdown()


if __name__ == "__main__":
    main()
