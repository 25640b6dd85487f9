"""Command lines that say in one line how they were called wrongly."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar

import typer
from er_models.one_line import BAD_USAGE
from typer.core import TyperCommand, TyperGroup

from er_common.keys import lacking


class OneLineGroup(TyperGroup):
    """Several commands; a wrong usage of any is one line and the exit status of bad usage."""

    moved: ClassVar[Mapping[str, str]] = {}
    """Commands that other programs have now: name to the words that start it there."""

    def main(self, *args: Any, **more: Any) -> Any:
        """Run a command and end the program; as `TyperGroup.main`."""
        words = (args[0] if args else more.get("args")) or sys.argv[1:]
        return _ended(super().main, args, more, *(w for w in words[:1] if w in self.commands))

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that is asked for; as `TyperGroup.resolve_command`."""
        if args[0] in self.moved:
            ctx.fail(f"'{args[0]}' is now '{self.moved[args[0]]}'")
        return super().resolve_command(ctx, args)


class OneLineCommand(TyperCommand):
    """A program that is one command; a wrong usage is one line and the exit status of bad usage."""

    def main(self, *args: Any, **more: Any) -> Any:
        """Run the command and end the program; as `TyperCommand.main`."""
        return _ended(super().main, args, more)


def _ended(
    run: Callable[..., Any], args: tuple[Any, ...], more: dict[str, Any], *command: str
) -> Any:
    """Run what parses and acts, and end the program with its status, unless the caller says that it is none.

    command: the one that was asked for.
    """
    if not more.get("standalone_mode", True):
        return run(*args, **more)
    program = more.get("prog_name") or Path(sys.argv[0]).name
    try:
        status = run(*args, **{**more, "standalone_mode": False})
    except typer.TyperException as error:
        said = _said(error, " ".join((program, *command)))
        if said:
            typer.echo(said, err=True)
        sys.exit(error.exit_code)
    except ModuleNotFoundError as error:
        line = lacking(" ".join((program, *command)), error)
        if not line:
            raise
        typer.echo(line, err=True)
        sys.exit(BAD_USAGE)
    sys.exit(status if isinstance(status, int) else 0)


def _said(error: typer.TyperException, command: str) -> str:
    """The command, what is wrong, and where help is; the help itself where nothing at all was asked.

    command: stands in where the error does not know it.
    """
    message = error.format_message()
    if type(error).__name__ == "NoArgsIsHelpError":
        return message
    context = getattr(error, "ctx", None)
    command = context.command_path if context else command
    message = " ".join(message.split()).removesuffix(".")
    return f"{command}: {message[:1].lower()}{message[1:]} ({command} --help)"
