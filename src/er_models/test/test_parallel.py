"""Work over the cores: every piece once, errors come back, and a fork starts afresh."""

from __future__ import annotations

import multiprocessing
import threading

import numpy as np
import pytest
from er_models.parallel import WORTH, in_turn, over_cores
from er_models.predict import predict, predict_many
from models_help import SMALL, guo, imposed

from er_models import parallel


@pytest.fixture(params=[1, 2, 3])
def cores(request, monkeypatch):
    monkeypatch.setattr(parallel, "cores", lambda: request.param)
    parallel._pool.cache_clear()
    yield request.param
    parallel._pool.cache_clear()


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


def test_an_error_comes_back(cores):
    def run(i, j):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        over_cores(run, 8, 10 * WORTH)


@pytest.mark.parametrize("n", [0, 1, 2, 7, 100])
def test_results_come_in_the_order_of_their_jobs(cores, n):
    told = []
    assert in_turn(lambda k: -k, range(n), told.append) == [-k for k in range(n)]
    assert told == list(range(n))
    assert in_turn(str, "ab") == ["a", "b"]


def test_unequal_jobs_do_not_wait_for_one_another(cores):
    """A core that is done takes the next job, and is told of in this thread, in order."""
    last = threading.Event()

    def run(k):
        if k == 0:
            assert cores == 1 or last.wait(10.0)  # the last is done while the first still works
        elif k == 5:
            last.set()
        return threading.current_thread()

    told = []
    in_turn(run, range(6), lambda k: told.append((k, threading.current_thread())))
    assert told == [(k, threading.current_thread()) for k in range(6)]


def test_what_a_job_spreads_is_taken_by_cores_with_nothing_to_do(cores):
    """The last job, all alone, is helped with; nobody waits for pieces that nobody has begun."""
    meeting = threading.Barrier(min(cores, 2))

    def run(k):
        over_cores(lambda i, j: meeting.wait(10.0), 2 if cores > 1 else 1, 10 * WORTH)

    in_turn(run, range(1))
    deep = in_turn(
        lambda a: in_turn(lambda b: in_turn(lambda c: a + b + c, range(3)), range(4)), range(5)
    )
    assert deep == [[[a + b + c for c in range(3)] for b in range(4)] for a in range(5)]


def test_after_an_error_no_job_is_begun(cores):
    done, lock = [], threading.Lock()

    def run(k):
        with lock:
            done.append(k)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        in_turn(run, range(100))
    assert len(done) <= cores


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
