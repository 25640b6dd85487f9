"""A damper or vehicle model: a list of effects with values, its envelope and where it comes from."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from er_models.catalogue import CATALOGUE, Catalogue
from er_models.errors import InputError, UnknownName
from er_models.kernel.compose import fingerprint
from er_models.kernel.layout import layout, responds
from er_models.measured import MeasuredTerm, packed
from er_models.scales import Scales

Array = NDArray[np.float64]
Values = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class Compiled:
    """A model as the flat vectors that the kernel takes.

    on: mask (`kernel.mask`); p (n_parameters,) values; slots: states in use; links: those of them that
    feed back; at_rest (n_states,).
    """

    on: NDArray[np.uint8]
    p: Array
    slots: NDArray[np.int64]
    links: NDArray[np.int64]
    at_rest: NDArray[np.uint8]


@dataclass(frozen=True)
class Model:
    """Effects and their parameter values [SI], the envelope of use, and provenance.

    `deviations` holds standard deviations of fitted values; `history` one entry per change the lab made;
    `terms`: what was learnt beside the effects, measured and not explained. `file` is where it was read from, empty
    where it was not.
    """

    name: str
    effects: Values
    scales: Scales
    source: str = ""
    deviations: Values = field(default_factory=dict)
    history: tuple[Mapping[str, Any], ...] = ()
    rig: Mapping[str, float] = field(default_factory=dict)
    catalogue: Catalogue = CATALOGUE
    terms: tuple[MeasuredTerm, ...] = ()
    file: str = field(default="", compare=False, repr=False)

    def __post_init__(self) -> None:
        unsaid = dict[str, dict[str, float]]()
        for name, values in self.effects.items():
            for parameter in values:
                self.catalogue.column(name, parameter)
            effect = self.catalogue[name]
            missing = [q for q in effect.parameters if q.name not in values]
            for q in missing:
                if q.name not in effect.unsaid:
                    key = f"{name}.{q.name}"
                    raise InputError(self.name, key, f"a value in {q.unit}", "nothing")
            if missing:
                unsaid[name] = {**values, **{q.name: effect.unsaid[q.name] for q in missing}}
        if unsaid:
            object.__setattr__(self, "effects", {**self.effects, **unsaid})

    @property
    def has_response(self) -> bool:
        """Whether the yield force lags: a model without any response time is static."""
        return responds(self.catalogue, self.effects)

    @property
    def is_vehicle(self) -> bool:
        """Whether the quarter car is part of the model."""
        return "quarter_car" in self.effects

    def value(self, effect: str, parameter: str) -> float:
        """One parameter value [SI]."""
        return float(self.effects[effect][parameter])

    def with_effect(self, name: str, values: Mapping[str, float] | None = None) -> Model:
        """This model with one effect more (or other values for it).

        What `values` leave out begins at its first start; where it is optional, it is neutral. Without `values` all
        begins at its first start.

        Raises:
            UnknownName: No such effect, or a parameter that it does not have.
        """
        effect = self.catalogue[name]
        for other in values or ():
            if other not in effect.names:
                raise UnknownName("parameter", other, effect.names)
        given = {**effect.unsaid, **values} if values else {}
        full = {
            q.name: float(given.get(q.name, self.start(name, q.name))) for q in effect.parameters
        }
        return replace(self, effects={**self.effects, name: full})

    def without_effect(self, name: str) -> Model:
        """This model with one effect less."""
        return replace(self, effects={k: v for k, v in self.effects.items() if k != name})

    def without_term(self, name: str) -> Model:
        """This model with one measured term less."""
        return replace(self, terms=tuple(t for t in self.terms if t.name != name))

    def start(self, effect: str, parameter: str, which: int = 0) -> float:
        """Starting value of a parameter [SI], from the scales of this model."""
        q = self.catalogue[effect].parameter(parameter)
        return q.starts[min(which, len(q.starts) - 1)] * self.scales.of(q.unit)

    def bounds(self, effect: str, parameter: str) -> tuple[float, float]:
        """Bounds of a parameter [SI], from the scales of this model."""
        q = self.catalogue[effect].parameter(parameter)
        scale = self.scales.of(q.unit)
        return q.low * scale, q.high * scale

    def compiled(self, plant: bool = False) -> Compiled:
        """Flat vectors for the kernel.

        plant: without the maps from measured to true motion, for where the motion is the true one.
        """
        c = self.catalogue
        p = np.zeros(c.size)
        for effect in (c[name] for name in self.effects):
            if not (plant and effect.maps_motion):
                for j, name in enumerate(effect.names):
                    p[c.offsets[effect.name] + j] = self.effects[effect.name][name]
        read = frozenset(name for term in self.terms for name in term.signals)
        on, slots, links, rest = layout(c, frozenset(self.effects), plant, read)
        p = np.concatenate([p, packed(self.terms)]) if self.terms else p
        return Compiled(on.copy(), p, slots.copy(), links.copy(), rest.copy())

    def digest(self) -> str:
        """Hash of what determines the behaviour: effects, values and equations."""
        values = {k: dict(sorted(v.items())) for k, v in sorted(self.effects.items())}
        terms = [term.as_json() for term in self.terms]
        text = json.dumps([values, fingerprint(self.catalogue), *terms], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]
