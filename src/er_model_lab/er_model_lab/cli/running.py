"""What every command of the lab does around its work: arguments, progress, results, exit status."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from er_models.errors import ErError, InputError
from er_models.one_line import INTERRUPTED
from rich.console import Console

from er_model_lab.cli.options import in_options, worded
from er_model_lab.cli.places import writable

if TYPE_CHECKING:
    from collections.abc import Iterator

    from er_records.dataset import Dataset

    from er_model_lab.results.result import Result
    from er_model_lab.work import Leader, Progress


def loaded(paths: Sequence[Path] | None) -> Dataset | None:
    """The data of an option; None where it was not given."""
    from er_model_lab.verbs.load import load

    return load(*paths) if paths else None


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


def damper_only(level: str, command: str) -> None:
    """Levels other than damper are refused in words."""
    if level == "vehicle":
        raise InputError("level", "", f"damper (lab {command} works on the damper force)", level)
    known_level(level)


def known_level(level: str) -> None:
    """A level that there is."""
    if level not in ("damper", "vehicle"):
        raise InputError("level", "", "damper or vehicle", level)


def run(
    work: Callable[[], Result],
    json_file: Path | None,
    report: Path | None,
    *,
    read: Mapping[str, Sequence[Path]],
    out: Path | None = None,
    beside: Path | None = None,
    table: Path | None = None,
    strict: bool = True,
) -> Result:
    """Do the work, write what was asked for, print one screen, and exit with the contract's status.

    out: where the new model or program goes; beside: where the work keeps what is done until then; table: a file
    that the work writes by itself; read: what the work reads, see `read_by`.
    """
    written: list[Path] = []
    try:
        writable({"--out": out or table, "--json": json_file}, report, read)
        result = _worded(_with_next(_kept(work(), out, written), read))
        if beside is not None:
            beside.unlink(missing_ok=True)
        page, errors = _write_rest(result, json_file, report, written)
        _print(result, page, out if result.model else None)
    except ErError as error:
        fail(error)
    except KeyboardInterrupt:
        typer.echo(f"interrupted: {_left_of(written, beside)}", err=True)
        raise typer.Exit(INTERRUPTED) from None
    for each in errors:
        typer.echo(in_options(each), err=True)
    if result.interrupted:
        again = "the same command with --resume" if table else "the same command"
        typer.echo(f"interrupted: what was done is written; {again} goes on from there", err=True)
        raise typer.Exit(INTERRUPTED)
    if errors:
        raise typer.Exit(errors[0].exit_status)
    if strict and not result.complete:
        typer.echo("the data were incomplete: see the notes", err=True)
        raise typer.Exit(3)
    return result


def _left_of(written: Sequence[Path], beside: Path | None) -> str:
    """What an interruption left, in words."""
    if written:
        return f"{' and '.join(map(str, written))} written, no more"
    if beside is not None and beside.is_file():
        return f"what was done is kept in {beside}; the same command goes on from there"
    return "nothing was written"


def _kept(result: Result, out: Path | None, written: list[Path]) -> Result:
    """The result once its model or program is written; noted in `written`."""
    program = getattr(result, "program", None)
    if out is None or (result.model is None and program is None):
        return result
    if program is not None:
        from er_models.program import save_program

        save_program(program, out)
        result = _with(result, program_file=str(out))
    elif result.model is not None:
        from er_models.files import save_model

        save_model(result.model, out)
    written.append(out)
    return result


def _with_next(result: Result, read: Mapping[str, Sequence[Path]]) -> Result:
    """The result with its suggested plans as commands that are ready to be pasted."""
    plans = result.view.result.get("next_plans")
    if plans is None:
        return result
    words = ["./er", "lab", "plan", "--model", str(read["--model"][0])]
    words += [w for f in read["DATA"] for w in ("--data", str(f))]
    words += [w for f in read["--effects-from"] for w in ("--effects-from", str(f))]
    words += ["--anyway"] * ("--anyway" in sys.argv)
    asked = [
        ["--between", *p["between"]] if "between" in p else ["--reveal", p["reveal"]]
        for p in plans
    ]
    return _with(result, next=[shlex.join([*words, *a, "--out", "next.yaml"]) for a in asked])


def _with(result: Result, **more: Any) -> Result:
    """The result with more in its content."""
    return replace(result, view=replace(result.view, result={**result.view.result, **more}))


def _worded(result: Result) -> Result:
    """The result with its sentences in the words of the command line."""
    view = result.view
    view = replace(view, result=worded(dict(view.result)), notes=worded(view.notes))
    return replace(result, view=view)


def _print(result: Result, page: Path | None, out: Path | None) -> None:
    """One screen of summary."""
    from er_model_lab.output.terminal.summary import summary

    console().print(summary(result.view), crop=False)
    if out:
        typer.echo(f"new model: {out}")
    if page:
        typer.echo(f"report: {page}")


def console() -> Console:
    """The terminal; a file or pipe is 100 columns wide."""
    return Console() if sys.stdout.isatty() else Console(width=100)


def _write_report(folder: Path | None, result: Result) -> Path | None:
    """The HTML report, when asked for."""
    return None if folder is None else result.report(folder)


def _write_rest(
    result: Result, json_file: Path | None, report: Path | None, written: list[Path]
) -> tuple[Path | None, list[ErError]]:
    """JSON and page, where asked for: the page, and what could not be written; a full disk may have room for one."""
    page, errors = None, list(getattr(result, "errors", ()))
    try:
        write_json(json_file, result.view.result)
        written += [json_file] if json_file is not None else []
    except ErError as error:
        errors.append(error)
    try:
        page = _write_report(report, result)
    except ErError as error:
        errors.append(error)
    return page, errors


def write_json(path: Path | None, result: Any) -> None:
    """The result as JSON, whole or not at all."""
    if path is not None:
        from er_models import files

        files.write_json(path, result)


def fail(error: ErError) -> None:
    """One clear line in the words of the command line, and the error's exit status."""
    typer.echo(in_options(error), err=True)
    raise typer.Exit(error.exit_status) from None


@contextmanager
def progress(title: str) -> Iterator[Progress | None]:
    """A progress bar on a terminal: the stage of the work, and which effect is ahead; None elsewhere."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Bar(*columns, TimeElapsedColumn(), console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=None)

        def told(stage: str, done: int, total: int, best: tuple[Leader, ...]) -> None:
            ahead = f" (ahead: {best[0].effect})" if best else ""
            bar.update(task, completed=done, total=total, description=f"{title}: {stage}{ahead}")

        yield told
