"""The model beside the damper, tick by tick: the force it predicts, the error, and what that says. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from er_common.gather import Tick
from er_common.stamps import SECOND
from er_models.following import Follower, Following, Sample, begin, follow, follower
from er_models.model import Model

from er_model_lab.monitor.sequential import Rules
from er_model_lab.monitor.watch import Part, Settings, Watch, watch

SETTLING = 1.0
"""Time after a beginning that is not judged: where the damper's states were is not known [s]."""
MOVING = 0.02
"""Share of the velocity that a damper is used at below which it counts as standing."""
DOUBT = 0.005
"""Share of it that the velocity may be off by, where the model file does not say how noisy it is."""
_NAN = math.nan
_LOST: tuple[tuple[float, ...], ...] = ((_NAN, _NAN), (_NAN, _NAN), (_NAN,), (_NAN,))


@dataclass(frozen=True)
class Monitor:
    """A model ready to be watched; hold: for how long a lost sample or duty is bridged [s]."""

    follower: Follower
    settings: Settings
    doubt: float
    hold: float


class Row(NamedTuple):
    """A tick as it was heard [SI]: its stamp [ns], NaN for what was lost."""

    stamp: int
    sprung: float
    unsprung: float
    x: float
    v: float
    u: float
    f: float


class State(NamedTuple):
    """Where the damper is, None before a sample; stamps of its last tick, last known duty and beginning [ns]."""

    damper: Following | None = None
    stamp: int = 0
    driven: int = 0
    begun: int = 0
    watch: Watch = Watch()


class Answer(NamedTuple):
    """Force of the model [N], NaN where it is not known; the error [N], NaN where nothing was to compare with."""

    force: float
    error: float


def monitor(model: Model, dt: float, hold: float, rules: Rules, floor: float = 0.0) -> Monitor:
    """A damper, or that of a car, at samples dt [s] apart; floor: known error [N], 0: it is learnt."""
    velocity = model.scales.velocity
    doubt = float(model.rig.get("velocity_noise", 0.0)) or DOUBT * velocity
    settings = Settings(rules, dt, MOVING * velocity, floor)
    return Monitor(follower(model, dt, (0.0, doubt, -doubt)), settings, doubt, hold)


def row_of(tick: Tick) -> Row:
    """What was heard of a tick."""
    (body, wheel), (x, v), (u,), (f,) = (
        lost if part is None else part for part, lost in zip(tick.parts, _LOST, strict=True)
    )
    return Row(tick.stamp, body, wheel, x, v, u, f)


def step(m: Monitor, state: State, row: Row) -> tuple[State, Answer]:
    """Go on to another tick.

    Without a deflection there is no force. A velocity or an acceleration that is missing is a difference quotient. Lost
    ticks and duties are bridged for a while; after that, and where time jumps back, the damper
    begins anew.
    """
    if not math.isfinite(row.x):
        return state, Answer(_NAN, _NAN)
    damper, elapsed = state.damper, row.stamp - state.stamp
    if damper is None or not 0 < elapsed <= m.hold * SECOND:
        if not math.isfinite(row.u):  # nobody can guess it
            return State(watch=state.watch), Answer(_NAN, _NAN)
        v, a = _known(row.v, 0.0), _known(row.sprung - row.unsprung, 0.0)
        damper = begin(m.follower, Sample(row.x, v, a, row.u))
        driven = begun = row.stamp
    else:
        damper = _followed(m, damper, row, elapsed / SECOND)
        driven, begun = row.stamp if math.isfinite(row.u) else state.driven, state.begun
    force, more, less = damper.forces.tolist()
    error, seen = row.f - force, state.watch
    known = row.stamp - driven <= m.hold * SECOND
    if known and math.isfinite(error) and row.stamp - begun >= SETTLING * SECOND:
        seen = watch(
            m.settings, seen, Part(error, 0.5 * (more - less), force, float(damper.sample[1]))
        )
    answer = Answer(force, error) if known else Answer(_NAN, _NAN)
    return State(damper, row.stamp, driven, begun, seen), answer


def _followed(m: Monitor, damper: Following, row: Row, elapsed: float) -> Following:
    """On to the next tick, in steps of a sample, straight from one to the other."""
    x, v, a, u, _ = damper.sample.tolist()
    now_v = _known(row.v, (row.x - x) / elapsed)
    now_a = _known(row.sprung - row.unsprung, (now_v - v) / elapsed)
    steps = max(round(elapsed / m.follower.dt), 1)
    for k in range(1, steps):
        q = k / steps
        between = Sample(x + q * (row.x - x), v + q * (now_v - v), a + q * (now_a - a), u)
        damper = follow(m.follower, damper, between)
    return follow(m.follower, damper, Sample(row.x, now_v, now_a, _known(row.u, u)))


def _known(value: float, otherwise: float) -> float:
    return value if math.isfinite(value) else otherwise
