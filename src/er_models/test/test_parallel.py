"""Work over the cores: every piece once, errors come back, and a fork starts afresh."""

from __future__ import annotations

import multiprocessing
import os
import threading

import numpy as np
import pytest
from er_models.parallel import LONGEST, WORTH, over_cores
from er_models.prediction import predict, predict_many
from models_help import SMALL, guo, imposed

from er_models import parallel


@pytest.fixture(params=[1, 2, 3])
def cores(request, monkeypatch):
    monkeypatch.setattr(parallel, "cores", lambda: request.param)
    parallel.threads.cache_clear()
    yield request.param
    parallel.threads.cache_clear()


@pytest.mark.parametrize("n", [0, 1, 2, 7, 100])
@pytest.mark.parametrize("steps", [1, 10 * WORTH])
def test_every_job_is_done_once(cores, n, steps):
    done, lock = [], threading.Lock()

    def run(i, j):
        with lock:
            done.extend(range(i, j))

    over_cores(run, n, steps)
    assert sorted(done) == list(range(n))


def test_small_work_stays_in_its_thread(cores):
    seen = set()
    over_cores(lambda i, j: seen.add(threading.current_thread()), 8, WORTH // 2)
    assert seen == {threading.current_thread()}


def test_no_piece_of_several_jobs_is_long(cores):
    """Ctrl-C waits for those that run, on one core too."""
    pieces = []
    over_cores(lambda i, j: pieces.append(j - i), 30, 10 * LONGEST)
    assert sum(pieces) == 30
    assert max(pieces) <= 3
    over_cores(lambda i, j: pieces.append(j - i), 3, 10 * LONGEST)
    assert pieces[-3:] == [1, 1, 1]


def test_an_error_comes_back(cores):
    def run(i, j):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        over_cores(run, 8, 10 * WORTH)


def test_a_piece_may_spread_work_of_its_own(cores):
    """Nobody waits for pieces that nobody has begun."""
    done, lock = [], threading.Lock()

    def deep(level):
        def run(i, j):
            for _ in range(i, j):
                if level:
                    over_cores(deep(level - 1), 3, 10 * WORTH)
                else:
                    with lock:
                        done.append(1)

        return run

    over_cores(deep(2), 5, 10 * WORTH)
    assert len(done) == 5 * 3 * 3


def test_what_no_other_thread_begins_is_done_here(cores):
    """All threads of the pool are busy with something else."""
    free = threading.Event()
    busy = [parallel.threads().submit(free.wait, 30.0) for _ in range(cores)]
    seen = []
    try:
        over_cores(lambda i, j: seen.append(threading.current_thread()), 8, 10 * WORTH)
    finally:
        free.set()
    assert seen
    assert set(seen) == {threading.current_thread()}
    assert all(b.result() for b in busy)


def test_after_an_error_here_no_piece_is_begun(cores):
    begun, over = [], threading.Event()

    def run(i, j):
        begun.append(i)
        if threading.current_thread() is threading.main_thread():
            raise ZeroDivisionError
        over.wait(30.0)

    with pytest.raises(ZeroDivisionError):
        over_cores(run, 100, 10 * WORTH)
    over.set()
    parallel.threads().shutdown()
    assert len(begun) <= cores + 1


@pytest.mark.parametrize(
    ("limit", "expected"), [("1", 1), ("64", len(os.sched_getaffinity(0))), ("", None), ("0", 1)]
)
def test_who_has_the_rest_of_the_machine_is_heard(monkeypatch, limit, expected):
    monkeypatch.setenv("NUMBA_NUM_THREADS", limit)
    assert parallel.cores() == (expected or len(os.sched_getaffinity(0)))


def rows():
    model, inputs = guo(), imposed(SMALL, 20.0)
    p = model.compiled().p
    return model, inputs, p * np.linspace(0.5, 1.5, 24)[:, None]


def test_rows_over_the_cores_are_those_of_single_predictions(cores):
    model, inputs, vectors = rows()
    assert vectors.shape[0] * inputs.n * 8 > WORTH
    forces = predict_many(model, vectors, inputs)
    assert (forces[12] == predict_many(model, vectors[12:13], inputs)[0]).all()
    alone = predict_many(model, model.compiled().p[None], inputs)
    assert (alone[0] == predict(model, inputs)).all()


def _forked(queue):
    model, inputs, vectors = rows()
    queue.put(predict_many(model, vectors, inputs))


@pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")
def test_a_forked_process_has_threads_of_its_own():
    """Threads do not survive a fork; waiting for those of the parent would never end."""
    model, inputs, vectors = rows()
    expected = predict_many(model, vectors, inputs)
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=_forked, args=(queue,))
    child.start()
    try:
        assert (queue.get(timeout=60) == expected).all()
    finally:
        child.kill()
        child.join()
