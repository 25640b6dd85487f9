"""`lab map`: what the columns of somebody's own files are, asked for on a terminal."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from er_models.errors import ErError, InputError

from er_model_lab.cli.options import Json
from er_model_lab.cli.places import writable
from er_model_lab.cli.running import console, fail, write_json

if TYPE_CHECKING:
    from er_records.mapping.mapping import Mapped

ASKED = ("t", "deflection", "deflection_velocity", "duty", "damper_force")
"""Channels that a terminal asks for; others are taken where they are likely."""
NEEDED = ("t", "deflection", "damper_force")
"""Channels without which hardly anything can be done."""


def map_command(
    path: Annotated[Path, typer.Argument(metavar="FILE_OR_FOLDER", help="Your own measurements.")],
    said: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="CHANNEL=COLUMN",
            help='What a channel is: damper_force="Kraft [kN]", duty="{from: Strom, full_scale: 1.6}", '
            'road="" for none. Repeatable.',
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="Mapping to write; else names.yaml in the folder.")
    ] = None,
    replaced: Annotated[
        bool, typer.Option("--replace", help="Write over a mapping that is there already.")
    ] = False,
    dry: Annotated[bool, typer.Option("--dry-run", help="Write nothing.")] = False,
    json_file: Json = None,
) -> None:
    """List columns with unit, range and rate, guess what they are, and write names.yaml for the folder."""
    try:
        from er_records.mapping.mapping import entry

        from er_model_lab.output.terminal.mapping import summary
        from er_model_lab.verbs.map import map as mapped

        given = dict(entry(text) for text in said or ())
        writable({"--out": out, "--json": json_file}, None, {"DATA": [path]})
        found = mapped(path, given)
        if sys.stdin.isatty() and sys.stdout.isatty() and not given:
            console().print(summary(found))
            found = mapped(path, _answers(found))
        console().print(summary(found), soft_wrap=True)
        written = (
            None
            if dry or found.needless or not _enough(found)
            else found.save(out, replaced=replaced)
        )
        write_json(json_file, found.to_dict() | {"written": str(written) if written else None})
        _say(found, written)
    except ErError as error:
        fail(error)


def _enough(found: Mapped) -> bool:
    """Whether the files can be read with it."""
    return not found.trouble and bool(found.records)


def _say(found: Mapped, written: Path | None) -> None:
    """What was written and what comes next; status 2 where the files cannot be read with it."""
    from er_records.mapping.mapping import option

    for channel, guess in found.unsure.items():
        typer.echo(f"not sure enough to be written: {option(channel, guess)}")
    if not _enough(found):
        why = found.trouble or "no column is known for certain"
        raise InputError(
            found.survey.path, "", f"columns that can be read; {_missing(found)}", why
        )
    seconds = sum(len(r) * r.dt for r in found.records)
    typer.echo(
        f"reads as {len(found.records)} record{'s' * (len(found.records) != 1)}, {seconds:.4g} s"
    )
    if found.hint:
        typer.echo(f"note: {found.hint}")
    if written:
        typer.echo(f"mapping: {written}")
    elif found.needless:
        typer.echo("every column has its name and unit: no mapping is needed")


def _missing(found: Mapped) -> str:
    """Options that would mend it."""
    from er_records.mapping.mapping import option

    lacking = [c for c in NEEDED if c not in found.sources]
    return " ".join(["say", *(option(c, found.unsure.get(c)) for c in lacking or ASKED[-1:])])


def _answers(found: Mapped) -> dict[str, Any]:
    """What a user at a terminal says of the columns: Enter takes the guess, - leaves the channel out."""
    columns = found.survey.columns
    given: dict[str, Any] = {}
    for channel in ASKED:
        guess = found.guesses.get(channel)
        default = guess.offer if guess else "-"
        asked = (
            f"{channel}: column by name or number, with [unit] where none is stated, - for none"
        )
        answer = typer.prompt(asked, default=default)
        number, *unit = answer.split(maxsplit=1)
        if number.isdigit() and 0 < int(number) <= len(columns):
            answer = " ".join([columns[int(number) - 1].header, *unit])
        given[channel] = None if answer.strip() == "-" else answer.strip()
    return given
