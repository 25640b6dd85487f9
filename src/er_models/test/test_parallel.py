"""Work over the cores: every piece once, errors come back, and a fork starts afresh."""

from __future__ import annotations

import multiprocessing
import threading

import numpy as np
import pytest
from er_models.parallel import WORTH, over_cores
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
