"""Columns of somebody's own files as a table: unit, range, rate, a sketch, and what they probably are."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from er_records.mapping.guess import SURE
from er_records.mapping.mapping import Mapped, sure_in_words
from er_records.record import Array
from rich import box
from rich.console import Group
from rich.markup import escape
from rich.table import Table
from rich.text import Text

BARS = "▁▂▃▄▅▆▇█"
WIDTH, PERIODS = 14, 3
"""Characters of a sketch, and periods of a motion that it shows."""


def summary(found: Mapped) -> Group:
    """The table of all columns, numbered as a question may name them, and why what is less than sure is so."""
    table = Table(box=box.SIMPLE_HEAD)
    for head in ("", "column", "unit", "range", "Hz", "sketch", "is", ""):
        narrow = head not in ("column", "is")
        table.add_column(head, overflow="fold", no_wrap=narrow)
    for number, seen in enumerate(found.survey.columns, start=1):
        guess, rate = found.channel_of(seen), found.rate_of(seen)
        table.add_row(
            str(number), escape(seen.name), escape(seen.unit or (guess.unit if guess else "")),
            f"{seen.low:.4g} to {seen.high:.4g}",
            f"{rate:.4g}" if np.isfinite(rate) else "", sketch(seen.samples), guess.channel if guess else "",
            f"{guess.sure:.0%}" if guess else "",
        )  # fmt: skip
    doubts = [
        Text(f"{c}: {sure_in_words(g)}: {'; '.join(g.why)}")
        for c, g in found.guesses.items() if g.sure < SURE
    ]  # fmt: skip
    number = len(found.survey.files)
    title = Text(f"{found.survey.path}: {number} file{'s' * (number != 1)}")
    return Group(title, table, *doubts)


def sketch(y: Array) -> str:
    """A signal (n,) as bars: its middle, a few periods of it where it swings."""
    y = y[np.isfinite(y)]
    if y.size < 2 or not np.ptp(y) > 0.0:
        return "─" * WIDTH
    part = _few_periods(y)
    edges = np.linspace(0, part.size, min(WIDTH, part.size) + 1).astype(int)
    means = np.array([part[i:j].mean() for i, j in pairwise(edges) if j > i])
    low, high = means.min(), means.max()
    level = (means - low) / (high - low) if high > low else np.full(means.size, 0.5)
    return "".join(BARS[round(v * (len(BARS) - 1))] for v in level)


def _few_periods(y: Array) -> Array:
    """The middle of a signal, `PERIODS` long where it crosses its mean often enough."""
    side = y > 0.5 * (np.quantile(y, 0.02) + np.quantile(y, 0.98))
    crossings = np.flatnonzero(side[1:] & ~side[:-1])
    if crossings.size < 2 * PERIODS:
        return y
    k = crossings.size // 2
    return y[crossings[k] : crossings[min(k + PERIODS, crossings.size - 1)] + 1]
