"""Loop times: percentiles are those of the numbers, losses are counted, repeated answers are not."""

from __future__ import annotations

import numpy as np
import pytest
from er_plant_sim.loop_times import BIN, Histogram, LoopTimes


@pytest.mark.parametrize("percent", [50.0, 99.0, 99.9])
def test_percentiles_are_right_to_a_bin(percent: float) -> None:
    times = np.random.default_rng(1).gamma(2.0, 0.001, 20_000)
    histogram = Histogram()
    for each in times:
        histogram.add(float(each))
    exact = float(np.percentile(times, percent, method="inverted_cdf"))
    assert 0.0 <= histogram.percentile(percent) - exact <= BIN + 1e-12
    assert histogram.longest == times.max()


def test_the_longest_counts_although_it_has_no_bin() -> None:
    histogram = Histogram()
    histogram.add(3.0)
    assert histogram.longest == 3.0


def test_unanswered_samples_are_counted_once_and_the_warm_up_not_at_all() -> None:
    loop = LoopTimes(first=100)
    for seq in range(1, 1101):
        loop.sensed(seq, 0.005 * seq, 0.0001)
        if seq % 100 != 50:
            loop.answered(seq, 0.005 * seq + 0.001)
            loop.answered(seq, 0.005 * seq + 0.004)
    loop.sensed(1101, 5.505, 0.0001)
    assert (loop.ticks, loop.unanswered) == (1002, 10)
    assert "loop ms p50 1.0" in loop.words()
    assert loop.latency.longest == pytest.approx(0.001)
