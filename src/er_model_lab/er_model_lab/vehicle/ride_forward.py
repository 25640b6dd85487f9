"""The level of the vehicle: all outputs of the car, weighted to newtons, as the rows of a fitting problem.

Row c of a sample is an output times `weights[c]`: its noise becomes that of the first output. So one newton is a
newton of the damper force where it is measured, else of the force that the body's acceleration shows.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from er_models.effect import Effect
from er_models.model import Array, Model
from er_models.scales import Scales

from er_model_lab.problem.forward import COARSE, Free, Limits, Output, Past
from er_model_lab.problem.motion_error import Sensed
from er_model_lab.vehicle.ride import CHANNELS, SETTLE, Course, drive, drive_many, with_values
from er_model_lab.work import HERE

CAR = ("m_us", "k_s", "k_t")
"""Parameters of the quarter car that are fitted. The sprung mass is what was weighed: its error is an effect."""
SENSORS = {
    "sense": "damper_force",
    "output_delay": "damper_force",
    "shift_deflection": "deflection",
    "shift_velocity": "deflection_velocity",
}
"""Channel whose sensor a hook of an effect of the sensors maps: no other channel shows it."""
ABSURD = 1e3
"""Outputs beyond this multiple of the largest measured one are none: the car has fallen over."""
FACTOR = 2.0
"""By so much these may be off: with an effect missing, a fit would else pay with a wheel without mass."""
NUDGE = 1e-3
"""Change of a start for its sensitivity, as a share of the motion's size."""


@dataclass(frozen=True)
class RideForward:
    """Records of a car, as `er_model_lab.problem.forward.Forward`.

    names, weights, noise (c,): outputs, newtons per unit of each, and its white noise; measured (n c,); sizes (4,):
    of the mechanical state; starts (blocks, 4); slopes: rows of each block by its start over `sizes`, (rows, 4);
    pulls: that start from the errors of the first rows, (4, rows); car: values of the quarter car as given.
    """

    dt: float
    courses: tuple[Course, ...]
    names: tuple[str, ...]
    weights: Array
    noise: Array
    measured: Array
    envelope: Scales
    car: Mapping[str, float]
    sizes: Array
    starts: Array
    slopes: tuple[Array, ...] = ()
    pulls: tuple[Array, ...] = ()

    @property
    def limits(self) -> Limits:
        """What is fitted of the quarter car stays near what was given."""
        return {
            ("quarter_car", name): (self.car[name] / FACTOR, self.car[name] * FACTOR)
            for name in CAR
        }

    @property
    def worth(self) -> float:
        """A third of what the smallest effect with a name gains: rides are long to simulate."""
        return 1.0 - 0.3e-2

    @property
    def outputs(self) -> int:
        """Rows of a sample."""
        return len(self.names)

    @property
    def channels(self) -> tuple[Output, ...]:
        """What each row of a sample is."""
        sizes = zip(self.names, self.weights, self.noise, strict=True)
        return tuple(Output(name, float(weight), float(noise)) for name, weight, noise in sizes)

    def blocks(self) -> Iterator[tuple[int, int]]:
        """First sample and end of every block, all records laid end to end."""
        offset = 0
        for path in self.courses:
            for i, j in itertools.pairwise(path.edges):
                yield offset + i, offset + j
            offset += path.edges[-1]

    def predict_many(self, data: Sensed, model: Model, vectors: Array) -> Array:
        """Rows (m, n) with the starts of the blocks that suit them."""
        del data
        rows = np.full((vectors.shape[0], self.measured.size), np.nan)
        able = ~np.isnan(vectors).any(axis=1)
        jobs = [(with_values(model, v), self.starts) for v in vectors[able]]
        found = self.weighted(drive_many(jobs, self.dt, self.courses))
        found[~(np.abs(found) < ABSURD * np.abs(self.measured).max())] = np.nan
        rows[able] = self.measured - self.settled(self.measured - found)
        return rows

    def predict(self, data: Sensed, model: Model) -> Array:
        """Rows (n,) of a model."""
        return np.asarray(self.predict_many(data, model, model.compiled().p[None])[0])

    def near(
        self, data: Sensed, model: Model, rows: Array, longest: float = COARSE
    ) -> RideForward:
        """Itself: nothing predicts a car for less that fits as well, since a mount is too stiff for longer steps."""
        del data, model, rows, longest
        return self

    def begun(self, data: Sensed, model: Model) -> RideForward:
        """Itself: all blocks begin where the rows before them say."""
        del data, model
        return self

    def predicted(self, data: Sensed, model: Model) -> tuple[Array, RideForward]:
        """Rows (n,) of a model, and itself."""
        return self.predict(data, model), self

    def beginnings(self, data: Sensed, model: Model) -> float:
        """None: the rows that the starts are made from are not scored."""
        del data, model
        return 0.0

    def ride(self, model: Model) -> tuple[Array, Array]:
        """Mechanical states (n, 4) and outputs (n, 8) of all records."""
        blocks = np.cumsum([0, *(len(p.edges) - 1 for p in self.courses)])
        pairs = zip(self.courses, itertools.pairwise(blocks), strict=True)
        runs = [drive(model, self.dt, path, self.starts[i:j]) for path, (i, j) in pairs]
        return np.concatenate([q for q, _ in runs]), np.concatenate([o for _, o in runs])

    def weighted(self, seen: Array) -> Array:
        """Rows (m, n c) of outputs (m, n, 8)."""
        columns = [CHANNELS[name] for name in self.names]
        with np.errstate(over="ignore"):  # a car that has fallen over
            rows = seen[:, :, columns] * self.weights
        return np.asarray(rows.reshape(len(seen), self.measured.size))

    def settled(self, errors: Array) -> Array:
        """Errors (m, n) less what other starts of the blocks explain.

        Sums in an order of their own: a matrix product rounds each row by how many there are and by its place.
        """
        out, c = errors.copy(), self.outputs
        for (i, j), slope, pull in zip(self.blocks(), self.slopes, self.pulls, strict=True):
            starts = np.einsum("mk,sk->sm", errors[:, i * c : i * c + pull.shape[1]], pull)
            for start, column in zip(starts, slope.T, strict=True):
                out[:, i * c : j * c] -= start[:, None] * column
        return out

    def free(self, model: Model) -> Free:
        """Parameters of damper and car; without the force only ratios are knowable: the body's mass is the measure."""
        return tuple(
            (name, q.name)
            for name in model.effects
            if model.catalogue[name].knowable
            for q in model.catalogue[name].parameters
            if q.fitted or (name == "quarter_car" and q.name in CAR)
        )

    def candidates(self, model: Model) -> tuple[Effect, ...]:
        """Effects of damper, car and those sensors that were recorded."""
        car = [
            e
            for e in model.catalogue.effects
            if e.stage == "vehicle" and any(q.fitted for q in e.parameters)
        ]
        return tuple(e for e in (*model.catalogue.candidates(), *car) if self._seen(e))

    def _seen(self, effect: Effect) -> bool:
        """Whether the channel was recorded that an effect of a sensor shows in."""
        shown = {SENSORS[hook] for hook in effect.hooks if hook in SENSORS}
        return effect.stage != "sensing" or shown <= set(self.names)

    def scales(self) -> Scales | None:
        """Envelope of the ride."""
        return self.envelope

    def past(self, data: Sensed) -> Past | None:
        """None: the motion of a car is predicted."""
        del data
        return None

    def input_errors(self, data: Sensed, model: Model, rng: np.random.Generator, m: int) -> Array:
        """None: road and duty are taken as they are; their errors are part of what is left."""
        del data, model, rng
        return np.zeros((m, self.measured.size))

    def output_errors(
        self, residual: Array, size: float, colour: float, rng: np.random.Generator, m: int
    ) -> Array:
        """What is left, moved along the record by any time and with any sign: its spectra stay, its causes do not."""
        del size, colour
        left = residual.reshape(-1, self.outputs)
        n = left.shape[0]
        moves = rng.integers(round(1.0 / self.dt), n - round(1.0 / self.dt), m)
        signs = rng.choice([-1.0, 1.0], m)
        drawn = [sign * np.roll(left, k, axis=0).ravel() for k, sign in zip(moves, signs)]
        return self.settled(np.array(drawn))


def with_starts(
    forward: RideForward, model: Model, *, rounds: int = 6, check: Callable[[], None] = HERE.check
) -> RideForward:
    """The forward model with fitted starts of all blocks (Gauss-Newton), and their sensitivities.

    check: raises where the work shall stop.
    """
    kept = trial = forward.starts
    best = np.full(trial.shape[0], np.inf)
    for _ in range(rounds):
        check()
        errors, slopes, pulls = _sensitivities(replace(forward, starts=trial), model)
        cost = np.array([float(np.mean(e**2)) for e in errors])
        better = cost < best
        if not np.any(cost < 0.99 * best):
            break
        best, kept = np.minimum(cost, best), np.where(better[:, None], trial, kept)
        step = np.array([pull @ e for pull, e in zip(pulls, errors, strict=True)]) * forward.sizes
        trial = np.where(better[:, None], trial + step, 0.5 * (trial + kept))
    _, slopes, pulls = _sensitivities(replace(forward, starts=kept), model)
    return replace(forward, starts=kept, slopes=slopes, pulls=pulls)


def _sensitivities(
    forward: RideForward, model: Model
) -> tuple[list[Array], tuple[Array, ...], tuple[Array, ...]]:
    """Errors of each block's first rows, its slopes and its pulls; the starts of all blocks move at once."""
    nudges = np.vstack([np.zeros(4), NUDGE * np.eye(4)]) * forward.sizes
    jobs = [(model, forward.starts + nudge) for nudge in nudges]
    rows = np.nan_to_num(forward.weighted(drive_many(jobs, forward.dt, forward.courses)))
    errors: list[Array] = []
    slopes: list[Array] = []
    pulls: list[Array] = []
    c, first = forward.outputs, round(SETTLE / forward.dt)
    for i, j in forward.blocks():
        part = slice(i * c, j * c)
        slope = (rows[1:, part] - rows[0, part]).T / NUDGE
        seen = slope[: first * c]
        errors.append((forward.measured[part] - rows[0, part])[: seen.shape[0]])
        slopes.append(slope)
        pulls.append(np.asarray(np.linalg.pinv(seen, rcond=1e-3), float))
    return errors, tuple(slopes), tuple(pulls)
