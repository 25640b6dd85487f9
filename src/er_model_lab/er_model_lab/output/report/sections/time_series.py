"""Measured and predicted force over time, what is left, and the motion and duty that caused it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from er_model_lab.output.report.figure import Axis, Band, Figure, Label, Line, Mark, Panel, Spans
from er_model_lab.output.report.palette import (
    AFTER,
    BEFORE,
    FLOOR,
    HELD_OUT,
    MEASURED,
    MODELS,
    MUTED,
)
from er_model_lab.output.report.section import Section
from er_model_lab.output.report.thin import end_to_end, stretches, timeline, worst_stretch
from er_model_lab.output.text.units import newtons, short
from er_model_lab.view import Array, RecordView, View

SECONDS = 5.0
"""Length of the stretch that is shown first."""
GRAIN = 0.05
"""Share of the noise floor to which forces are kept for zooming."""


@dataclass(frozen=True)
class Chart:
    """Records on one time axis; grain: what is finer is noise [N]."""

    records: tuple[RecordView, ...]
    times: tuple[Array, ...]
    grain: float

    @cached_property
    def t(self) -> Array:
        """Time (n,) of all records, NaN between them [s]."""
        return end_to_end(self.times)

    @property
    def both(self) -> bool:
        """Whether there is a model after beside the one before."""
        return all(r.after is not None for r in self.records)

    @property
    def label(self) -> str:
        """Label of the time axis."""
        return "time [s]" if len(self.records) == 1 else "time, records laid end to end [s]"

    def curve(
        self, of: Callable[[RecordView], Array | None], name: str, colour: str, width: float = 1.3
    ) -> list[Mark]:
        """One curve through all records; forces, which have a name, are kept to the grain."""
        y = end_to_end([p for r in self.records if (p := of(r)) is not None])
        return [Line(self.t, y, name, colour, width, grain=self.grain if name else 0.0)]

    def names(self) -> list[Mark]:
        """Name of each record where it begins, when there are several."""
        if len(self.records) == 1:
            return []
        return [Label(float(x[0]), r.name) for r, x in zip(self.records, self.times, strict=True)]

    def held_out(self) -> list[Mark]:
        """Shading of what was never fitted."""
        pairs = zip(self.records, self.times, strict=True)
        found = [s for r, x in pairs for s in stretches(x, r.held_out & r.scored)]
        return [Spans(tuple(found), "held out", HELD_OUT)] if found else []


def section(view: View) -> Section | None:
    """All records end to end, starting where the model is worst; None without records."""
    records = [r for r in view.records if r.t.size > 2]
    if not records:
        return None
    times = timeline(records)
    k = max(range(len(records)), key=lambda i: worst_stretch(records[i], SECONDS)[2])
    low, high, rms = worst_stretch(records[k], SECONDS)
    shift = float(times[k][0] - records[k].t[0])
    start = (low + shift, high + shift)
    where = f"{short(low)} s to {short(high)} s of {records[k].name}"
    chart = Chart(tuple(records), times, GRAIN * float(view.result.get("noise_floor") or 0.0))
    held = chart.held_out() if isinstance(view.result.get("rmse"), Mapping) else []
    figure = _figure(view, chart, held, start, f"Shown is the stretch of largest error, {where}.")
    facts = {"where": where, "rms": newtons(rms), "split": bool(held)}
    return Section("time_series", "Force over time", (figure,), facts)


def _figure(
    view: View, chart: Chart, held: list[Mark], start: tuple[float, float], words: str
) -> Figure:
    """Four linked panels: force, residual, velocity, duty."""
    others = [name for name, _ in chart.records[0].others]
    before = "model before" if chart.both else view.model if others else "model"
    force = chart.curve(lambda r: r.measured, "measured", MEASURED, 1.1)
    force += chart.curve(lambda r: r.before, before, BEFORE)
    left = chart.curve(lambda r: r.measured - r.before, before, BEFORE)
    if chart.both:
        force += chart.curve(lambda r: r.after, "model after", AFTER)
        left += chart.curve(_left_after, "model after", AFTER)
    for k, name in enumerate(others):
        colour = MODELS[(k + 1) % len(MODELS)]
        force += chart.curve(lambda r, k=k: r.others[k][1], name, colour)  # type: ignore[misc]
        left += chart.curve(lambda r, k=k: r.measured - r.others[k][1], name, colour)  # type: ignore[misc]
    velocity = chart.curve(lambda r: 1e3 * r.velocity, "", MUTED, 1.0)
    duty = chart.curve(lambda r: r.duty, "", MUTED, 1.2)
    span = Axis(span=start)
    panels = (
        Panel((*held, *force, *chart.names()), span, Axis("force [N]")),
        Panel((*held, *_floor(view), *left), span, Axis("residual [N]")),
        Panel(tuple(velocity), span, Axis("v [mm/s]")),
        Panel(tuple(duty), Axis(chart.label, start), Axis("duty")),
    )
    alt = f"Force measured and predicted over time, what is left of it, velocity and duty. {words}"
    heights = (3.0, 2.2, 1.0, 1.0)
    return Figure("time_series", alt, panels, height=720, heights=heights, linked=True)


def _left_after(r: RecordView) -> Array:
    """What the model leaves with what was added; only where there is such a model."""
    return r.measured - (r.before if r.after is None else r.after)


def _floor(view: View) -> list[Mark]:
    """Band in which noise alone stays 95 % of the time."""
    floor = view.result.get("noise_floor")
    if floor is None or not np.isfinite(floor):
        return []
    return [Band(-2.0 * floor, 2.0 * floor, "noise floor (2 rms, 95 %)", FLOOR)]
