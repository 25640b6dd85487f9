"""How late a duty acts, learnt from the duties that acted."""

from __future__ import annotations

import math

import numpy as np
import pytest
from er_ftc_controller.lateness import MOST, Lateness, hear, say
from er_models.constants import SAMPLE_TIME as DT


def followed(
    duties: np.ndarray, late: int, lost: frozenset[int] = frozenset(), steps: float = 0.0
) -> list[int | None]:
    """What is believed after each sample; steps: of an actuator that takes no finer duty."""
    state, believed = Lateness(), []
    for k, duty in enumerate(duties):
        asked = k - 1 - late
        acted = float(duties[asked]) if asked >= 0 else 0.0
        acted = steps * round(acted / steps) if steps else acted
        if k not in lost:
            state = hear(state, k * DT, acted)
        state = say(state, k * DT, float(duty))
        believed.append(state.late)
    return believed


def moving(seed: int = 0, n: int = 400) -> np.ndarray:
    return np.clip(
        0.2 + 0.2 * np.cumsum(np.random.default_rng(seed).normal(0.0, 0.1, n)), 0.0, 1.0
    )


@pytest.mark.parametrize("late", range(MOST + 1))
def test_the_lateness_of_a_moving_duty_is_found_and_kept(late: int) -> None:
    believed = followed(moving(late), late)
    assert believed[60:] == [late] * 340
    assert set(believed) <= {None, late}


@pytest.mark.parametrize("late", [0, 2])
def test_lost_samples_and_coarse_duties_do_not_mislead(late: int) -> None:
    lost = frozenset(np.flatnonzero(np.random.default_rng(1).random(400) < 0.1).tolist())
    assert set(followed(moving(), late, lost, steps=0.01)[100:]) == {late}


def test_a_duty_that_stands_still_or_is_somebody_elses_teaches_nothing() -> None:
    assert set(followed(np.full(400, 0.3), 2)) == {None}
    assert set(followed(np.full(400, 0.3) + 0.0005 * moving(), 2)) == {None}
    state = Lateness()
    for k, (own, other) in enumerate(zip(moving(1), moving(2), strict=True)):
        state = say(hear(state, k * DT, float(other)), k * DT, float(own))
    assert state.late is None


def test_what_was_learnt_stays_while_the_duty_stands_still_and_follows_a_change() -> None:
    duties = np.concatenate([moving(3), np.full(200, 0.4)])
    assert followed(duties, 2)[-1] == 2
    state, believed = Lateness(), []
    duties = moving(4, 800)
    for k, duty in enumerate(duties):
        late = 1 if k < 400 else 3
        acted = float(duties[max(k - 1 - late, 0)])
        state = say(hear(state, k * DT, acted), k * DT, float(duty))
        believed.append(state.late)
    assert believed[399] == 1
    assert believed[-1] == 3


def test_no_duty_and_no_memory_change_nothing() -> None:
    assert hear(Lateness(), 0.0, 0.2) == Lateness()
    state = Lateness(said=((0.0, 0.1),) * (MOST + 2))
    assert hear(state, DT, math.nan) is state
    assert len(say(state, DT, 0.2).said) == MOST + 2
