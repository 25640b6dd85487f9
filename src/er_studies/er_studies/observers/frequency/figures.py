"""Which figure of the thesis shows what."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from er_observers.gains import Gains

from er_studies.observers.frequency.responses import HERTZ, Response, outputs, respond

UNIFIED, POLYTOPIC, GRIDDING = "unified", "nlpv_polytopic", "nlpv_gridding"


class Figure(NamedTuple):
    """A figure: its number, what from, of which observers, Bode (each error) or singular values."""

    number: str
    source: str
    observers: tuple[str, ...]
    bode: bool


FIGURES = (
    Figure("3.1", "noise", (UNIFIED,), bode=False),
    Figure("3.2", "noise", (UNIFIED,), bode=True),
    Figure("4.1", "road", (POLYTOPIC,), bode=True),
    Figure("4.2", "road", (GRIDDING,), bode=True),
    Figure("4.3", "noise", (POLYTOPIC,), bode=True),
    Figure("4.4", "noise", (GRIDDING,), bode=True),
    Figure("4.5", "gate", (POLYTOPIC,), bode=True),
    Figure("4.6", "gate", (GRIDDING,), bode=True),
    Figure("4.7", "road", (POLYTOPIC, GRIDDING), bode=False),
    Figure("4.8", "noise", (POLYTOPIC, GRIDDING), bode=False),
    Figure("5.1", "noise", (UNIFIED,), bode=True),
    Figure("5.2", "noise", (POLYTOPIC,), bode=True),
    Figure("5.3", "noise", (GRIDDING,), bode=True),
    Figure("5.4", "noise", (UNIFIED, POLYTOPIC, GRIDDING), bode=True),
)


class Peak(NamedTuple):
    """Where one error is largest: figure, observer, duty, error, gain [SI], frequency [Hz]."""

    figure: str
    observer: str
    duty: float
    error: str
    gain: float
    hertz: float


def responses(figure: Figure, gains: dict[str, Gains]) -> list[Response]:
    """One response per observer and duty: the nodes of its law, once where they are all alike."""
    found = []
    for name in figure.observers:
        claim = gains[name].claim
        law = claim.solution.law
        alike = np.array_equal(law.M[0], law.M[-1]) and figure.source != "gate"
        nodes = law.rho[:1] if alike else law.rho
        if figure.source == "gate":  # at duty 0 the gate moves nothing
            nodes = np.where(nodes == 0.0, 0.01 * law.rho[-1], nodes)
        found += [respond(name, claim, float(rho), figure.source) for rho in nodes]
    return found


def peaks(figure: Figure, gains: dict[str, Gains]) -> list[Peak]:
    """The largest gain of every error in a figure, or of the singular value."""
    found = []
    for r in responses(figure, gains):
        names = outputs(gains[r.observer].claim) if figure.bode else ("all states",)
        columns = r.gains if figure.bode else r.sigma[:, None]
        for name, column in zip(names, columns.T, strict=True):
            at = int(np.argmax(column))
            found.append(
                Peak(figure.number, r.observer, r.duty, name, float(column[at]), float(HERTZ[at]))
            )
    return found
