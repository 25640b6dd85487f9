"""Strength of a hidden effect: what a refitted healthy base cannot absorb hits a drawn target."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from test.blind.effect import Effect, Scene, between
from test.blind.errors import BlindError
from test.blind.integrate import LEAD_SAMPLES, SUBSTEPS
from test.blind.jit import Array
from test.blind.measure import noiseless
from test.blind.plant import NO_EFFECT, Motion, trajectory
from test.blind.refit import excess, left_for, refit
from test.blind.slots import C0, OFER, OV, OX

LEAST_RISE, MOST_RISE = 0.10, 6.0
_DRAWN_RISE = (0.15, 4.0)
_CLOSE = 0.08
_TRIALS = 7
_DRAWS = 4


@dataclass(frozen=True)
class Hidden:
    """One hidden effect of a case.

    Attributes:
        effect: what it is.
        row: its parameters, (N_COLUMNS,); the strength first.
        target: rise of the residual over the floor that was drawn; 0.1 is 10 %. Zero for an effect of the car.
        rise: the rise reached with this effect alone; the same.
    """

    effect: Effect
    row: Array
    target: float
    rise: float


def clean_records(
    motions: Sequence[Motion], table: Array, base: Array, seconds: float
) -> list[dict[str, Array]]:
    """Noiseless contract columns of each motion.

    Raises:
        BlindError: the motion did not stay finite.
    """
    records = []
    for motion in motions:
        fine = trajectory(motion, table, base)
        if not np.isfinite(fine).all():
            raise BlindError("simulation: expected finite motion, found a diverging effect")
        records.append(noiseless(fine, motion, table, seconds))
    return records


def scene_of(motions: Sequence[Motion], base: Array, seconds: float) -> Scene:
    """What the undisturbed damper does on these motions."""
    fine = np.concatenate(
        [trajectory(m, NO_EFFECT, base)[LEAD_SAMPLES * SUBSTEPS :: SUBSTEPS] for m in motions]
    )
    return Scene(fine[:, OX], base[C0] * fine[:, OV] + fine[:, OFER], base, seconds)


def table_of(hidden: Sequence[Hidden]) -> Array:
    """Effect table with the rows of the hidden effects."""
    table = NO_EFFECT.copy()
    for one in hidden:
        table[one.effect.slot] = one.row
    return table


def solve(
    left: Callable[[float], float], start: float, goal: float, span: tuple[float, float]
) -> tuple[float, float]:
    """Strength whose residual left(strength) [N] comes close to the goal, and that residual.

    Secant steps on logarithms; the local exponent starts at one and is learnt. At the end of the
    span the closest strength tried is the answer.
    """
    strength, power, tried = min(max(start, span[0]), span[1]), 1.0, []
    for _ in range(_TRIALS):
        tried.append((strength, left(strength)))
        if abs(np.log(tried[-1][1] / goal)) < _CLOSE:
            break
        if len(tried) > 1 and tried[-1][0] != tried[-2][0]:
            slope = np.log(tried[-1][1] / tried[-2][1]) / np.log(tried[-1][0] / tried[-2][0])
            power = min(max(float(slope), 0.4), 3.0)
        step = float(np.clip((goal / tried[-1][1]) ** (1.0 / power), 0.1, 10.0))
        following = min(max(strength * step, span[0]), span[1])
        if following == strength:
            break
        strength = following
    return min(tried, key=lambda pair: abs(np.log(pair[1] / goal)))


def hide(
    effect: Effect,
    motions: Sequence[Motion],
    scene: Scene,
    noise: float,
    rng: np.random.Generator,
    target: float | None = None,
) -> Hidden:
    """Draw an effect's shape and sign, and set its strength to the target, or draw it.

    Args:
        effect: what to hide.
        motions: inputs of the records.
        scene: what the undisturbed damper does on them.
        noise: standard deviation of the force channel [N], the floor.
        rng: draws shape, sign and target.
        target: rise over the floor; drawn where absent.

    Raises:
        BlindError: no strength in the effect's range shows by at least 10 % and at most 600 %.
    """
    if not effect.shown_by_force:
        strength = between(rng, effect.least, effect.most)
        negative = effect.most_negative > 0.0 and rng.random() < 0.5
        size = -min(strength, effect.most_negative) if negative else strength
        return Hidden(effect, effect.row(size, effect.draw(rng, scene)), 0.0, 0.0)
    goal = target if target is not None else between(rng, *_DRAWN_RISE)
    rise = strength = 0.0
    for _ in range(_DRAWS):
        shape = effect.draw(rng, scene)
        negative = effect.most_negative > 0.0 and rng.random() < 0.5
        sign, most = (-1.0, effect.most_negative) if negative else (1.0, effect.most)

        def left(size: float, sign: float = sign, shape: tuple[float, ...] = shape) -> float:
            table = NO_EFFECT.copy()
            table[effect.slot] = effect.row(sign * size, shape)
            records = clean_records(motions, table, scene.base, scene.seconds)
            return refit(records, offset=not effect.hides_in_bias).rms

        strength, rms = solve(left, effect.typical, left_for(goal, noise), (effect.least, most))
        rise = excess(rms, noise)
        if LEAST_RISE <= rise <= MOST_RISE:
            return Hidden(effect, effect.row(sign * strength, shape), goal, rise)
    raise BlindError(
        f"{effect.name}: expected a rise of 10 to 600 % over the noise, found {rise:.1%}"
        f" at strength {sign * strength:.3g}"
    )
