"""The error against one quantity after the other, and the regions that carry most of it."""

from __future__ import annotations

import numpy as np

from er_model_lab.output.report.figure import Axis, Bars, Figure, Mark, Panel, Points
from er_model_lab.output.report.palette import BEFORE, FLOOR, RESIDUAL
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.regions import NOTABLE, Failure, failures, worst
from er_model_lab.output.text.units import newtons, percent, shown, ticks, where
from er_model_lab.residual.region import RegionTable
from er_model_lab.view import View

COLUMNS = 3


def section(view: View) -> Section | None:
    """The error beyond the noise per bin with 90 % bands, and the worst regions; None without tables.

    Of the model with what was added first, where something was, then of the one before.
    """
    shown = [
        (tables, after)
        for tables, after in ((view.regions_after, True), (view.regions, False))
        if tables
    ]
    if not shown:
        return None
    names = {
        True: "with what was added",
        False: "before anything was added" if len(shown) > 1 else "",
    }
    parts = [
        {"model": names[after], "worst": [_row(f) for f in failures(tables, view.records, after=after)]}
        for tables, after in shown
    ]  # fmt: skip
    figures = tuple(
        _figure(list(tables), "where_it_still_fails" if after else "where_it_fails", names[after])
        for tables, after in shown
    )
    return Section(
        "where_it_fails", "Where it fails", figures, {"parts": parts, "both": len(shown) > 1}
    )


def _row(f: Failure) -> tuple[str, ...]:
    """A region in words, its share of the squared error and of the samples, its error, what exceeds the noise, when."""
    r = f.region
    beyond = newtons(r.excess) + f" ({newtons(r.excess_band[0])} to {newtons(r.excess_band[1])})"
    when = f"{f.when[0]}, {f.when[1]:.0f} s" if f.when else ""
    return (
        where(r, single=f.single), percent(r.share), percent(r.of_samples), newtons(r.rms), beyond, when,
    )  # fmt: skip


def _figure(tables: list[RegionTable], name: str, model: str) -> Figure:
    """One panel per quantity on a common scale."""
    top = 1.08 * max(max(r.excess, r.excess_band[1], r.floor) for t in tables for r in t.regions)
    panels = tuple(_panel(t, k, max(top, 1e-9)) for k, t in enumerate(tables))
    leading = worst(tables)
    words = (
        f" The largest excess is at {where(leading[0][0], single=leading[0][1])}."
        if leading
        else ""
    )
    names = ", ".join(t.quantity for t in tables)
    alt = f"Error{' ' * bool(model)}{model} in excess of the noise per bin of {names}, with 90 % bands.{words}"
    columns = min(COLUMNS, len(tables))
    return Figure(name, alt, panels, columns, height=225 * (-(-len(tables) // columns)) + 60)


def _panel(table: RegionTable, k: int, top: float) -> Panel:
    """Bars of one quantity; bins with far more than their share of the error stand out."""
    regions = table.regions
    at = np.arange(len(regions), dtype=np.float64)
    excess = np.array([r.excess for r in regions])
    ends = np.array([[r.excess_band[0] for r in regions], [r.excess_band[1] for r in regions]])
    hot = np.array([r.share > NOTABLE * r.of_samples for r in regions])
    marks: list[Mark] = []
    for name, mask, colour in (
        ("more error than its share", hot, BEFORE),
        ("no more than its share", ~hot, RESIDUAL),
    ):
        if mask.any():
            bars = Bars(
                at[mask],
                excess[mask],
                name,
                (colour,) * int(mask.sum()),
                ends=ends[:, mask],
                width=0.92,
            )
            marks.append(bars)
    marks.append(Points(at, np.array([r.floor for r in regions]), "noise there", FLOOR, 5.0, 1.0))
    unit = f" [{shown(table.unit)}]" if shown(table.unit) else ""
    y = Axis("excess error [N]" if k % COLUMNS == 0 else "", (0.0, top))
    return Panel(
        tuple(marks),
        Axis(ticks=ticks(regions), span=(-0.6, at.size - 0.4)),
        y,
        table.quantity + unit,
    )
