"""The sections of the page, in reading order; each is None when the view holds no data for it."""

from __future__ import annotations

from collections.abc import Callable

from er_model_lab.output.report.section import Section
from er_model_lab.output.report.sections import (
    alternatives,
    candidates,
    cards,
    falling_error,
    fleet,
    headline,
    history,
    identified,
    loops,
    measured_terms,
    models,
    motion,
    noise,
    preflight,
    programs,
    provenance,
    residual_maps,
    spectrum,
    summary,
    time_series,
    unexplained,
    where_it_fails,
)
from er_model_lab.view import View

FLEET: tuple[Callable[[View], Section | None], ...] = (
    fleet.section, fleet.units, fleet.effects, fleet.parameters, fleet.changes, fleet.planned, fleet.recordings,
    provenance.section,
)  # fmt: skip
"""The sections of a fleet's page."""
SECTIONS: tuple[Callable[[View], Section | None], ...] = (
    headline.section,
    programs.section,
    models.section,
    falling_error.section,
    summary.section,
    identified.section,
    measured_terms.section,
    alternatives.section,
    time_series.section,
    loops.section,
    residual_maps.section,
    where_it_fails.section,
    spectrum.section,
    noise.section,
    unexplained.section,
    candidates.section,
    cards.section,
    preflight.section,
    motion.section,
    history.section,
    provenance.section,
)
