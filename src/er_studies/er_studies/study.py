"""``./er study``: the thesis made again, and measured data sets brought into the lab's columns."""

from __future__ import annotations

import typer
from er_common.usage import OneLineGroup

from er_studies.importers.command import import_command
from er_studies.thesis.command import thesis_command

app = typer.Typer(
    cls=OneLineGroup,
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Make the thesis again, and bring measured data sets of others into the lab's columns.",
)
app.command("thesis", short_help="Make a chapter of the thesis again.")(thesis_command)
app.command("import", short_help="Convert a measured data set.")(import_command)


def main() -> None:
    """Entry point."""
    app(prog_name="./er study")


if __name__ == "__main__":
    main()
