"""What a problem predicts and how its data err: all that differs between the levels of the lab."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import ClassVar, Protocol

import numpy as np
from er_models.effect import Effect
from er_models.model import Array, Model
from er_models.prediction import (
    SUBSTEP,
    Motion,
    Told,
    beginnings,
    caught,
    predict,
    predict_many,
    substeps,
)
from er_models.scales import Scales
from numpy.typing import NDArray

from er_model_lab.filtering import fading
from er_model_lab.problem.motion_error import Sensed, drawn

Free = tuple[tuple[str, str], ...]
Limits = Mapping[tuple[str, str], tuple[float, float]]
COARSE, ROUGH = 2.5e-3, 5e-3
"""Steps of the integrator with which a fit looks for its way [s], where it ends is predicted in the usual ones; and
those with which candidates are only ranked."""
Past = tuple[Motion, NDArray[np.intp]]
"""Motion of whole records, and which rows of it data are."""


@dataclass(frozen=True)
class Output:
    """One output: the channel that measures it, newtons per unit of that channel, and its white noise in this unit."""

    name: str
    weight: float
    noise: float = float("nan")


class Forward(Protocol):
    """A level of the lab: rows (n,) of data that a model predicts, `outputs` of them for each sample.

    data: the motion, and what it was made from; candidates: effects of the catalogue that may be tried; free:
    parameters that are fitted, (effect, name).
    input_errors (m, n): errors [N] that draws of the input sensors' noise cause; output_errors (m, n): noise
    as the residual (n,) of a fit shows it, `size` [N] and lag-one correlation `colour` of its training rows.
    """

    @property
    def outputs(self) -> int:
        """Rows of a sample."""

    @property
    def channels(self) -> tuple[Output, ...]:
        """What each row of a sample is."""

    @property
    def limits(self) -> Limits:
        """Bounds [SI] of parameters by (effect, name), in place of the catalogue's."""

    @property
    def worth(self) -> float:
        """Share of the mean square that the first step with an effect may leave; else no more are taken."""

    def predict_many(self, data: Sensed, model: Model, vectors: Array) -> Array:
        """Rows (m, n) of one model for m flat parameter vectors (m, n_parameters)."""

    def predict(self, data: Sensed, model: Model) -> Array:
        """Rows (n,) of a model."""

    def near(self, data: Sensed, model: Model, rows: Array, longest: float = COARSE) -> Forward:
        """What predicts rows for less near a model that predicts these (n,): exact there; itself where nothing does.

        longest: its step of the integrator [s].
        """

    def begun(self, data: Sensed, model: Model) -> Forward:
        """What predicts rows for less, as they begin about where those of a model do, exact there; or itself."""

    def predicted(self, data: Sensed, model: Model) -> tuple[Array, Forward]:
        """Rows (n,) of a model, and what `begun` makes of it, for the price of the first."""

    def beginnings(self, data: Sensed, model: Model) -> float:
        """How many numbers the data have told of where the states of a model begin, beside its parameters."""

    def free(self, model: Model) -> Free:
        """Fitted parameters of a model."""

    def candidates(self, model: Model) -> tuple[Effect, ...]:
        """Effects of the catalogue that may be tried."""

    def scales(self) -> Scales | None:
        """Envelope of the data; None where motion and force say it themselves."""

    def past(self, data: Sensed) -> Past | None:
        """What the damper did from the beginning of each record on; None where no force of it is predicted."""

    def input_errors(self, data: Sensed, model: Model, rng: np.random.Generator, m: int) -> Array:
        """Errors (m, n) that other draws of the input sensors' noise would have caused."""

    def output_errors(
        self, residual: Array, size: float, colour: float, rng: np.random.Generator, m: int
    ) -> Array:
        """Noise (m, n) of the outputs as it may have been."""


@dataclass(frozen=True)
class DamperForward:
    """The force of the damper, from its measured motion; its states begin where the measured force says.

    longest: step of the integrator [s]; beside: what such steps leave out (n,) [N]; caught: about where states begin
    that a contact may catch (`Told.caught`).
    """

    longest: float = field(default=SUBSTEP, kw_only=True)
    beside: Array | None = field(default=None, kw_only=True, compare=False)
    caught: Array | None = field(default=None, kw_only=True, compare=False)

    outputs: ClassVar = 1
    channels: ClassVar = (Output("damper_force", 1.0),)
    limits: ClassVar[Limits] = MappingProxyType({})
    worth: ClassVar = np.inf

    def predict_many(self, data: Sensed, model: Model, vectors: Array) -> Array:
        """Forces (m, n) along the motion."""
        return self._complete(
            predict_many(model, vectors, data.motion, self._told(data), longest=self.longest)
        )

    def _told(self, data: Sensed) -> Told:
        """What tells where states begin, with about where that is as far as it is known."""
        return data.told if self.caught is None else replace(data.told, caught=self.caught)

    def predict(self, data: Sensed, model: Model) -> Array:
        """Force (n,) along the motion."""
        return np.asarray(self.predict_many(data, model, model.compiled().p[None])[0])

    def near(self, data: Sensed, model: Model, rows: Array, longest: float = COARSE) -> Forward:
        """The same in longer steps, with their error at the model taken off."""
        if substeps(data.motion.dt, longest) >= substeps(data.motion.dt, self.longest):
            return self
        coarse = replace(self, longest=longest, beside=None)
        return replace(coarse, beside=rows - coarse.predict(data, model))

    def begun(self, data: Sensed, model: Model) -> DamperForward:
        """The same, without a look for where what a contact may catch begins; exact at the model."""
        return self._looked(data, model)[1]

    def predicted(self, data: Sensed, model: Model) -> tuple[Array, DamperForward]:
        """Force (n,) along the motion, and the same as `begun`."""
        rows, forward = self._looked(data, model)
        return (self.predict(data, model) if rows is None else rows), forward

    def _looked(self, data: Sensed, model: Model) -> tuple[Array | None, DamperForward]:
        """Force (n,) and what is begun there, where something had to be looked for, else None and the same."""
        found = caught(model, data.motion, self._told(data), longest=self.longest)
        if found is None:
            return None, self
        rows, near = self._complete(found[0]), replace(self, caught=found[1], beside=None)
        return rows, replace(near, beside=rows - near.predict(data, model))

    def _complete(self, forces: Array) -> Array:
        """Forces (m, n) with what their steps leave out."""
        return forces if self.beside is None else forces + self.beside

    def beginnings(self, data: Sensed, model: Model) -> float:
        """Of all states and records."""
        coarse = max(self.longest, COARSE)
        return beginnings(model, data.motion, self._told(data), longest=coarse)

    def free(self, model: Model) -> Free:
        """Fitted parameters of the damper.

        What acts in the car is not fitted to a damper force, nor is a gain that it cannot show: these
        keep the model's values.
        """
        return free_parameters(model)

    def candidates(self, model: Model) -> tuple[Effect, ...]:
        """Effects of the damper and its sensors."""
        return model.catalogue.candidates()

    def scales(self) -> Scales | None:
        """Nothing beyond motion and force."""
        return None

    def past(self, data: Sensed) -> Past | None:
        """Its motion, of which the data are every row."""
        return data.motion, np.arange(data.motion.n)

    def input_errors(self, data: Sensed, model: Model, rng: np.random.Generator, m: int) -> Array:
        """Forces along motions that the sensors may have meant, less that along the fused one."""
        coarse = replace(self, longest=max(self.longest, COARSE)).begun(data, model)
        told, longest = coarse._told(data), coarse.longest
        seen = predict(model, data.motion, told, longest=longest)
        drawings = (drawn(data, rng) for _ in range(m))
        return np.array([predict(model, d, told, longest=longest) - seen for d in drawings])

    def output_errors(
        self, residual: Array, size: float, colour: float, rng: np.random.Generator, m: int
    ) -> Array:
        """First-order autoregressive noise of the force."""
        white = rng.standard_normal((m, residual.size)) * np.sqrt(1.0 - colour**2)
        return size * fading(white, colour)


@dataclass(frozen=True)
class PartForward(DamperForward):
    """The force along stretches, with bounds and starts in the scales of all runs."""

    whole: Scales

    def scales(self) -> Scales:
        """Envelope of all runs."""
        return self.whole


def colour_of(r: Array) -> float:
    """Lag-one correlation of what a model leaves (n,)."""
    return float(np.mean(r[1:] * r[:-1]) / max(float(np.mean(r**2)), 1e-300))


def free_parameters(model: Model) -> Free:
    """Parameters of the damper's effects that channels can show."""
    return tuple(
        (name, q.name)
        for name in model.effects
        if model.catalogue[name].stage != "vehicle" and model.catalogue[name].knowable
        for q in model.catalogue[name].parameters
        if q.fitted
    )


DAMPER = DamperForward()
