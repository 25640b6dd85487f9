"""What every command of the lab does around its work: request, progress, results, exit status."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from er_models.errors import ErError, InputError
from rich.console import Console

from er_model_lab.cli.places import writable

if TYPE_CHECKING:
    from collections.abc import Iterator

    from er_model_lab.verbs.ask import Outcome, Request
    from er_model_lab.work import Work


def asked(
    data: list[Path],
    model: Path,
    seed: int,
    hold_out: list[Path] | None,
    effects_from: list[Path] | None,
    level: str = "damper",
    anyway: bool = False,
) -> Request:
    """The request of a command line."""
    from er_model_lab.verbs.ask import Request

    known_level(level)
    return Request(
        data,
        model,
        seed,
        tuple(hold_out or ()),
        tuple(effects_from or ()),
        level=level,
        anyway=anyway,
    )


def read_by(
    data: list[Path] | None,
    models: Sequence[Path],
    effects_from: list[Path] | None,
    hold_out: list[Path] | None = None,
) -> dict[str, Sequence[Path]]:
    """What most commands read: argument or option to its paths."""
    return {
        "DATA": data or (),
        "--model": models,
        "--effects-from": effects_from or (),
        "--hold-out": hold_out or (),
    }


def known_level(level: str) -> None:
    """A level that there is."""
    if level not in ("damper", "vehicle"):
        raise InputError("--level", "", "damper or vehicle", level)


def damper_only(level: str, command: str) -> None:
    """Levels other than damper are refused in words."""
    if level == "vehicle":
        raise InputError(
            "--level", "", f"damper (lab {command} works on the damper force)", "vehicle"
        )
    known_level(level)


def run(
    work: Callable[[], Outcome],
    json_file: Path | None,
    report: Path | None,
    out: Path | None = None,
    *,
    read: Mapping[str, Sequence[Path]],
    strict: bool = True,
    program: Path | None = None,
) -> Outcome:
    """Do the work, write what was asked for, print one screen, and exit with the contract's status.

    out: new model, announced; read: what the work reads, see `read_by`; program: another file that the work itself
    writes and tells of.
    """
    written: list[Path] = []
    try:
        writable({"--out": out or program, "--json": json_file}, report, read)
        outcome = work()
        made = program if outcome.result.get("program_file") else out
        written += [made] if made is not None else []
        write_json(json_file, outcome.result)
        written += [json_file] if json_file is not None else []
        page = _write_report(report, outcome)
        _print(outcome, page, out)
    except ErError as error:
        fail(error)
    except KeyboardInterrupt:
        kept = (
            f"{' and '.join(map(str, written))} written, no more"
            if written
            else "nothing was written"
        )
        typer.echo(f"interrupted: {kept}", err=True)
        raise typer.Exit(130) from None
    if outcome.interrupted:
        typer.echo(
            "interrupted: what was done is written; the same command goes on from there", err=True
        )
        raise typer.Exit(130)
    if strict and not outcome.complete:
        typer.echo("the data were incomplete: see the notes", err=True)
        raise typer.Exit(3)
    return outcome


def _print(outcome: Outcome, page: Path | None, out: Path | None) -> None:
    """One screen of summary."""
    from er_model_lab.output.terminal.summary import summary

    console().print(summary(outcome.view), crop=False)
    if out:
        typer.echo(f"new model: {out}")
    if page:
        typer.echo(f"report: {page}")


def console() -> Console:
    """The terminal; a file or pipe is 100 columns wide."""
    return Console() if sys.stdout.isatty() else Console(width=100)


def _write_report(folder: Path | None, outcome: Outcome) -> Path | None:
    """The HTML report, when asked for."""
    if folder is None:
        return None
    from er_model_lab.output.report.page import write_report

    return write_report(outcome.view, folder)


def write_json(path: Path | None, result: Any) -> None:
    """The result as JSON, whole or not at all."""
    if path is not None:
        from er_models.files import write_whole

        write_whole(path, json.dumps(result, indent=1, allow_nan=False) + "\n")


def fail(error: ErError) -> None:
    """One clear line and the error's exit status."""
    typer.echo(" ".join(str(error).split()), err=True)
    raise typer.Exit(error.exit_status) from None


@contextmanager
def working(title: str) -> Iterator[Work]:
    """How the work of a command is done, with a progress bar on a terminal: its stage, and which effect is ahead."""
    from er_model_lab.work import Leader, Work

    if not sys.stderr.isatty():
        yield Work()
        return
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
    )

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(
        *columns, TimeElapsedColumn(), console=Console(stderr=True), transient=True
    ) as bar:
        task = bar.add_task(title, total=None)

        def told(stage: str, done: int, total: int, best: tuple[Leader, ...]) -> None:
            ahead = f" (ahead: {best[0].effect})" if best else ""
            bar.update(task, completed=done, total=total, description=f"{title}: {stage}{ahead}")

        yield Work(progress=told)
