"""The test on the error of a model: how often it calls in vain, and how soon it calls."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from er_model_lab.monitor.sequential import HOUR, RULES, Known, Rules, learnt
from er_model_lab.monitor.simulated import Drive, alarms, delays
from er_model_lab.monitor.watch import HIGHEST

DRIVES = {
    "white, noise alone": Drive(),
    "coloured, noisy motion": Drive(colour=0.6, parts=(0.02, 0.1, 0.0)),
    "more coloured, model off, gusts": Drive(colour=0.8, parts=(0.02, 0.1, 0.001), gusts=0.2),
}
HOURS, RUNS = 64.0, 128


@pytest.mark.parametrize("drive", DRIVES.values(), ids=list(DRIVES))
def test_false_alarms_are_as_rare_as_stated(drive: Drive) -> None:
    """One in 24 h; docs/monitor.md has a thousand hours."""
    assert alarms(RULES, drive, HOURS, RUNS, seed=3) <= 1.5 * HOURS * HOUR / RULES.between


@pytest.mark.parametrize("drive", DRIVES.values(), ids=list(DRIVES))
def test_an_error_that_grows_by_a_third_is_found_within_ten_seconds(drive: Drive) -> None:
    found = delays(RULES, drive, 1.3, RUNS, seed=4)
    assert np.median(found) < 10.0
    # and no change is found in no time, or the test above could not fail
    assert np.median(delays(RULES, drive, 1.0, RUNS, seed=5, longest=20.0)) == math.inf


def known(scatter: float, blocks: int = 240, floor: float = 0.0) -> Known:
    """What is learnt of blocks about 4 N2 that scatter so much."""
    rng = np.random.default_rng(1)
    power = 4.0 * np.exp(scatter * rng.standard_normal(blocks))
    return learnt(RULES, power, np.ones((blocks, 3)), floor)


def test_the_limit_grows_with_the_scatter_and_with_what_is_not_known() -> None:
    assert known(0.2).limit < known(0.4).limit < known(0.4, 60).limit


def test_what_takes_too_long_is_told() -> None:
    assert known(0.2).delay(0.3, RULES.block) < 3.0
    assert known(1.0).delay(0.3, RULES.block) > 20.0
    assert known(0.2).delay(0.05, RULES.block) == math.inf


def test_one_wild_block_is_no_alarm() -> None:
    k, motion = known(0.2), np.ones(3)
    once = k.added(0.0, 1e9, motion)
    assert once < k.limit
    assert k.added(k.added(once, 1e9, motion), 1e9, motion) >= k.limit


def test_an_alarm_does_not_come_and_go_with_quiet_blocks_and_ends_after_a_while_without_a_sign() -> (
    None
):
    k, quiet, blocks = known(0.2), np.ones(3), 0
    left = HIGHEST * float(k.limit)
    assert k.added(left, 1e-6, quiet) == 0.0, "one quiet block ends what is no alarm yet"
    while left > 0.0:
        left, blocks = float(k.added(left, 1e-6, quiet, failing=True)), blocks + 1
    assert blocks * RULES.block == pytest.approx(20.0, abs=1.0)


def test_a_rougher_road_is_no_alarm_and_its_error_is_learnt_part_by_part() -> None:
    rng = np.random.default_rng(2)

    def blocks(rough: float, n: int) -> tuple[Any, Any]:
        doubt, force = rng.exponential(1.0, n), rough * rng.exponential(30.0, n)
        motion = np.column_stack([np.ones(n), doubt, force])
        power = motion @ [0.02, 0.1, 0.002] * rng.chisquare(50, n) / 50.0
        return power, motion

    k = learnt(RULES, *blocks(1.0, 960))
    assert k.coefficients == pytest.approx([0.02, 0.1, 0.002], rel=0.2)
    power, motion = blocks(9.0, 400)
    total = highest = 0.0
    for each, m in zip(power, motion, strict=True):
        total = float(k.added(total, each, m))
        highest = max(highest, total)
    assert highest < k.limit
    assert power.mean() > 4.0 * float(k.power)


def test_a_known_floor_is_what_the_error_is_compared_with() -> None:
    k = known(0.2, floor=1.0)
    assert float(k.expected(np.ones(3))) == pytest.approx(1.0, rel=0.1)
    total = 0.0
    for _ in range(20):
        total = float(k.added(total, 4.0, np.ones(3)))
    assert total > k.limit


def test_more_time_between_alarms_is_a_higher_limit() -> None:
    power = np.random.default_rng(1).chisquare(50, 240) / 50.0
    day, week = (
        learnt(Rules(between=h * HOUR), power, np.ones((240, 3))).limit for h in (24.0, 168.0)
    )
    assert day < week < 1.3 * day
