"""`./er study thesis CHAPTER`: what a chapter of the thesis shows, made again in simulation."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import typer
from er_model_lab.cli.options import seed_option
from er_models.errors import ErError
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from er_studies.programs import program_of, run

if TYPE_CHECKING:
    from er_model_lab.output.report.section import Section
    from er_model_lab.view import View

Tick = Callable[[str], None] | None


def thesis_command(
    chapter: Annotated[
        Literal["chapter1", "chapter2", "chapter6"],
        typer.Argument(
            help="chapter1: identify and validate the dampers; chapter2: the car in all its forms; "
            "chapter6: faults and the duties that mimic them."
        ),
    ],
    config: Annotated[
        Path, typer.Option("--config", help="Folder with models, programs and sensor noise.")
    ] = Path("config"),
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write the machine-readable result here.")
    ] = None,
    report: Annotated[
        Path | None, typer.Option("--report", help="Write an HTML report into this folder.")
    ] = None,
    seed: Annotated[int, seed_option("Seed of the sensors' noise.")] = 0,
) -> None:
    """Make again what a chapter of the thesis shows, with its figures beside ours."""
    try:
        with _progress(chapter) as tick:
            made = _CHAPTERS[chapter](config, seed, tick)
        if json_file is not None:
            from er_models.files import write_json

            write_json(json_file, made.data)
        typer.echo("\n".join(made.lines))
        if report is not None:
            from er_model_lab.output.report.page import write_report

            view, sections = made.page()
            typer.echo(f"report: {write_report(view, report, sections)}")
    except ErError as error:
        typer.echo(" ".join(str(error).split()), err=True)
        raise typer.Exit(error.exit_status) from None


class _Made(NamedTuple):
    """A chapter as plain data, as lines for the screen, and what makes its page."""

    data: dict[str, Any]
    lines: list[str]
    page: Callable[[], tuple[View, list[Section]]]


def _chapter_1(config: Path, seed: int, tick: Tick) -> _Made:
    """Identify the damper models as in section 1.5 and validate them on the four cases of section 1.6."""
    from er_studies.thesis.chapter_1 import chapter_1
    from er_studies.thesis.chapter_1_text import lines, result

    found = chapter_1(config, seed, tick)
    data = result(found, seed)

    def page() -> tuple[View, list[Section]]:
        from er_studies.thesis.report.chapter_1 import sections, view

        return view(found, data), sections(found, data)

    return _Made(data, lines(found), page)


def _chapter_2(config: Path, _seed: int, tick: Tick) -> _Made:
    """The quarter car in all its forms; nothing in it is random."""
    from er_studies.thesis.chapter_2 import chapter_2
    from er_studies.thesis.chapter_2_text import lines, result

    found = chapter_2(config, tick)
    data = result(found)

    def page() -> tuple[View, list[Section]]:
        from er_studies.thesis.report.chapter_2 import sections, view

        return view(found, data), sections(found, data)

    return _Made(data, lines(found), page)


def _chapter_6(config: Path, _seed: int, tick: Tick) -> _Made:
    """Faults of the damper and the duties that mimic them; nothing in it is random."""
    from er_studies.thesis.chapter_6 import chapter_6
    from er_studies.thesis.chapter_6_text import lines, result

    found = chapter_6(config, tick)
    data = result(found)

    def page() -> tuple[View, list[Section]]:
        from er_studies.thesis.report.chapter_6 import sections, view

        return view(found, data), sections(found, data)

    return _Made(data, lines(found), page)


_CHAPTERS: dict[str, Callable[[Path, int, Tick], _Made]] = {
    "chapter1": _chapter_1,
    "chapter2": _chapter_2,
    "chapter6": _chapter_6,
}


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


app = program_of(thesis_command)

if __name__ == "__main__":
    run(app)
