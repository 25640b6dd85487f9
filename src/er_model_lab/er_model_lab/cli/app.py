"""Command line of the model lab: `er lab COMMAND`, or `er-lab COMMAND`."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import typer
from er_common.usage import OneLineGroup

from er_model_lab.cli.data import check, compare, identify
from er_model_lab.cli.missing import add, diagnose, improve
from er_model_lab.cli.plan import effects, plan
from er_model_lab.command_line import by_er

COMMANDS: dict[Callable[..., None], str] = {
    check: "Check measurements before anything is fitted.",
    compare: "Say where a model fails; several side by side.",
    diagnose: "Say which effect is missing, with evidence.",
    add: "Add one effect and refit everything.",
    improve: "Diagnose and add until nothing is missing.",
    plan: "Plan the run that tells two effects apart.",
    identify: "Identify every parameter in stages.",
    effects: "The catalogue of effects, or one effect's card.",
}
"""In the order in which they are used, with one line each that fits a terminal."""


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
for command, line in COMMANDS.items():
    app.command(short_help=line)(command)


def main() -> None:
    """Entry point."""
    app(prog_name="./er lab" if by_er() else None)


if __name__ == "__main__":
    main()
