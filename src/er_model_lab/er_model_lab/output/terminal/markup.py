"""Text for a terminal in colour, or as plain ASCII for a file or a pipe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rich.table import Table
from rich.text import Text

BLOCK = "\N{FULL BLOCK}"
PLUS_MINUS = "\N{PLUS-MINUS SIGN}"
ASCII = str.maketrans({
    BLOCK: "#", PLUS_MINUS: "+-", "\N{MINUS SIGN}": "-", "\N{RIGHTWARDS ARROW}": "->", "\N{MICRO SIGN}": "u",
})  # fmt: skip
"""Stand-ins for what a file or a pipe may not carry."""


@dataclass(frozen=True)
class Pen:
    """Writes text for one kind of output."""

    width: int
    plain: bool

    def safe(self, text: str) -> str:
        """The text, as ASCII where only that is sure to arrive."""
        return text.translate(ASCII).encode("ascii", "replace").decode() if self.plain else text

    def line(self, text: str, style: str = "") -> Text:
        """Text that wraps at the width."""
        return Text(self.safe(text), style="" if self.plain else style)

    def whole(self, text: str) -> Text:
        """A line that is left as long as it is: the terminal wraps it, and still copies it as one."""
        return Text(self.safe(text), no_wrap=True, overflow="ignore")

    def cut(self, text: str, most: int) -> str:
        """The text in at most this many characters."""
        text = self.safe(text)
        return text if len(text) <= most else text[: max(most - 3, 0)].rstrip(" ,;") + "..."

    def table(
        self, columns: Sequence[tuple[str, str]], rows: Sequence[Sequence[str | Text]]
    ) -> Table:
        """A table without lines; columns are (title, justify), and only text wraps, never a number."""
        grid = Table(
            box=None,
            pad_edge=False,
            padding=(0, 2, 0, 0),
            header_style="" if self.plain else "dim",
        )
        for title, justify in columns:
            grid.add_column(
                title,
                justify="right" if justify == "right" else "left",
                no_wrap=justify != "",
                overflow="fold",
            )
        for row in rows:
            # as text, because a bracket in a name must not be taken for markup
            grid.add_row(*(Text(cell) if isinstance(cell, str) else cell for cell in row))
        return grid
