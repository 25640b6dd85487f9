"""`er bench fleet`: the simulated cluster does every recording, and keeps its workers and its scheduler in bounds."""

import asyncio

import numpy as np
import pytest
from er_model_lab.fleets.engine import AHEAD, SECONDS, batch_size
from er_studies.bench.fleet.cluster import Costs, simulated

TIMES = np.array([0.3, 0.4, 0.5])


def outcome(workers, recordings, *, gather=1e-3, seed=1):
    """A simulated fleet."""
    return asyncio.run(simulated(workers, recordings, Costs(1e-3, 2e-4, gather, TIMES), seed))


def test_workers_are_busy_until_the_end():
    found = outcome(5, 400)
    assert found.seconds == pytest.approx(400 * TIMES.mean() / 5, rel=0.1)
    assert found.busy > 0.9
    assert found.most <= AHEAD * 5
    assert found.batches < 150


def test_a_slow_scheduler_is_the_limit():
    found = outcome(20, 400, gather=0.5)
    assert found.seconds > 0.5 * found.batches
    assert found.scheduler > 0.9
    assert found.busy < 0.5


def test_batches_grow_with_the_cluster():
    assert batch_size(0.0, 10) == 1
    assert batch_size(0.5, 2) == SECONDS / 0.5
    assert batch_size(0.5, 1000) == 30
    assert 1e6 / batch_size(1.2, 1000) < 100_000  # a million recordings of a minute
    assert batch_size(60.0, 2) == 1
