"""`er lab thesis chapter1`: the validation cases of the thesis, made again in simulation."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from er_models.errors import ErError
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn


def register(parent: typer.Typer) -> None:
    """Add the command `thesis` to the lab's application."""
    parent.command("thesis")(thesis_command)


def thesis_command(
    chapter: Annotated[Literal["chapter1"], typer.Argument(help="What to make again.")],
    config: Annotated[
        Path, typer.Option("--config", help="Folder with models, programs and sensor noise.")
    ] = Path("config"),
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write the machine-readable result here.")
    ] = None,
    report: Annotated[
        Path | None, typer.Option("--report", help="Write an HTML report into this folder.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the sensors' noise.")] = 0,
) -> None:
    """Identify the damper models as in section 1.5 and validate them on the four cases of section 1.6."""
    from er_model_lab.thesis.cases import chapter_1
    from er_model_lab.thesis.present import lines, result

    try:
        with _progress(chapter) as tick:
            found = chapter_1(config, seed, tick)
        data = result(found, seed)
        if json_file is not None:
            from er_models.files import write_whole

            write_whole(json_file, json.dumps(data, indent=1, allow_nan=False) + "\n")
        typer.echo("\n".join(lines(found)))
        if report is not None:
            typer.echo(f"report: {_report(found, data, report)}")
    except ErError as error:
        typer.echo(" ".join(str(error).split()), err=True)
        raise typer.Exit(error.exit_status) from None


def _report(found: Any, data: dict[str, Any], folder: Path) -> Path:
    """Write the page with the pictures of the cases."""
    from er_model_lab.report.page import write_report
    from er_model_lab.report.thesis import sections, view

    return write_report(view(found, data), folder, sections(found, data))


@contextmanager
def _progress(title: str) -> Iterator[Callable[[str], None] | None]:
    """What is being done and for how long, on a terminal only."""
    if not sys.stderr.isatty():
        yield None
        return
    shown = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*shown, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=None)
        yield lambda what: bar.update(task, description=f"{title}: {what}")
