"""What a report or a terminal shows: plain data, filled by the commands, drawn elsewhere."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from er_models.cards.equation import Equation, equations
from er_models.catalogue import Catalogue
from numpy.typing import NDArray

from er_model_lab.residual.region import RegionTable

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RecordView:
    """One record: all arrays (n,), SI; `before` is the model as given and refitted, `after` with what was added.

    others: name and prediction (n,) of further models that are compared with the first.
    """

    name: str
    t: Array
    deflection: Array
    velocity: Array
    duty: Array
    measured: Array
    before: Array
    after: Array | None
    scored: NDArray[np.bool_]
    held_out: NDArray[np.bool_]
    others: tuple[tuple[str, Array], ...] = ()


@dataclass(frozen=True)
class CandidateView:
    """One effect as the lab saw it: numbers of the contract's JSON and its signature against the residual."""

    effect: str
    title: str
    physics: str
    catalogue: Catalogue
    mark: str
    experiment: str
    entry: Mapping[str, Any]
    reason: str
    plane: str
    signature_x: Array
    signature_y: Array
    residual_y: Array

    @property
    def equations(self) -> tuple[Equation, ...]:
        """Equations of the effect, as the card typesets them."""
        return equations(self.catalogue[self.effect])


@dataclass(frozen=True)
class ImitationView:
    """One truth and its best imitation along a program: forces (n,) [N], and the noise floor [N]."""

    truth: str
    imitation: str
    force: Array
    imitated: Array
    floor: float


@dataclass(frozen=True)
class ProgramView:
    """A planned program: road [m], deflection [m] and duty over time, each (n,), and one cycle's length [s]."""

    name: str
    t: Array
    road: Array
    deflection: Array
    duty: Array
    cycle: float
    imitations: tuple[ImitationView, ...]


@dataclass(frozen=True)
class SeriesView:
    """A quantity of one unit that changes: values y (n,), deviations s (n,) along x (n,) [m or s]."""

    unit: str
    quantity: str
    axis: str
    x: Array
    y: Array
    s: Array
    change: Mapping[str, Any]


@dataclass(frozen=True)
class FleetView:
    """What a page shows of a fleet beside the result: rows of its units, the strangest first; values that change.

    total: units there are; pages: unit to the page of its own, relative to the report.
    """

    rows: tuple[Mapping[str, Any], ...]
    total: int
    series: tuple[SeriesView, ...]
    pages: Mapping[str, str]


@dataclass(frozen=True)
class View:
    """Everything a report of one command shows.

    headline: one line in newtons; result: the contract's JSON; regions: where the model fails before anything is
    added; regions_after: where it fails with what was added, on the same data, empty where nothing was; candidates best
    first; steps: the falling error; notes: what was repaired, derived or left out; programs: planned ones,
    the proposed one first; rival_regions: of several models that are compared, name and where each fails; fleet: of
    many units.
    """

    command: str
    model: str
    headline: str
    result: Mapping[str, Any]
    records: tuple[RecordView, ...]
    regions: tuple[RegionTable, ...] = ()
    candidates: tuple[CandidateView, ...] = ()
    notes: tuple[str, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)
    programs: tuple[ProgramView, ...] = ()
    regions_after: tuple[RegionTable, ...] = ()
    rival_regions: tuple[tuple[str, tuple[RegionTable, ...]], ...] = ()
    fleet: FleetView | None = None
