"""A command line whose wrong usage is one line. No ROS here."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from typing import NoReturn

from er_models.errors import ErError

BAD_USAGE = 2
"""Exit status of wrong usage."""
INTERRUPTED = 130
"""Exit status after Ctrl-C."""


class OneLine(argparse.ArgumentParser):
    """Says what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        """End with the line and the status of bad usage."""
        sys.stderr.write(f"{self.prog}: {message}\n")
        sys.exit(BAD_USAGE)


def end_with(program: str, command: Callable[[], int]) -> NoReturn:
    """Run a command and end with its status; what a user can cause is one line and the status of its error."""
    try:
        status = command()
    except ErError as error:
        sys.stderr.write(f"{program}: {error}\n")
        status = error.exit_status
    sys.exit(status)
