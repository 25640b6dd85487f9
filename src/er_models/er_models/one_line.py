"""A command line whose wrong usage is one line. No ROS here."""

from __future__ import annotations

import argparse
import sys
from typing import NoReturn

BAD_USAGE = 2
"""Exit status of wrong usage."""


class OneLine(argparse.ArgumentParser):
    """Says what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        """End with the line and the status of bad usage."""
        sys.stderr.write(f"{self.prog}: {message}\n")
        sys.exit(BAD_USAGE)
