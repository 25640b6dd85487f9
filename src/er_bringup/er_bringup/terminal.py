"""Where commands print what is more than a line."""

import sys

from rich.console import Console


def console() -> Console:
    """The terminal; a file or pipe is 120 columns wide."""
    return Console() if sys.stdout.isatty() else Console(width=120)
