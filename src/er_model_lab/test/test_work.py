"""Jobs of a search: the same results whoever does them, told as they come, and stopped at once."""

import multiprocessing
import os
import pickle
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import made_ready
from er_model_lab.diagnosis.investigation import search_effects
from er_model_lab.diagnosis.ranking import TRYING
from er_model_lab.fitting.fit import fit
from er_model_lab.jobs import processes as own_processes
from er_model_lab.problem import problem as problem_module
from er_model_lab.problem.forward import DamperForward
from er_model_lab.problem.prepare import prepare
from er_model_lab.work import HERE, Cancelled, Leader, Work
from er_models.catalogue import CATALOGUE
from er_models.files import load_model
from er_models.own import effects
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import DT, GUO, imposed, problem_of


@pytest.fixture(scope="module")
def processes():
    """Two processes that are started anew, as a user may hand them in."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, context) as pool:
        yield pool


@pytest.fixture(scope="module")
def threads():
    with ThreadPoolExecutor(2) as pool:
        yield pool


@pytest.fixture(params=["here", "threads", "processes"])
def executor(request):
    return None if request.param == "here" else request.getfixturevalue(request.param)


def product(job, factor):
    return job * factor


def test_results_come_in_the_order_of_their_jobs_and_are_told_as_they_come(executor):
    told = []
    work = Work(executor, lambda *words: told.append(words))
    ahead = partial(sorted, reverse=True)
    found = work.map(product, range(5), 3, stage="threes", best=lambda done: ahead(done)[:1])
    assert found == [0, 3, 6, 9, 12]
    assert [words[:3] for words in told] == [("threes", k + 1, 5) for k in range(5)]
    assert told[-1][3] == (12,)
    work.report("another", 0, 1)
    assert told[-1] == ("another", 0, 1, (12,))
    assert work.map(product, [], 3) == []


class Counted:
    """Something large; every process that opens it leaves a line in a file."""

    def __init__(self, file):
        self.file = file

    def __setstate__(self, state):
        self.__dict__.update(state)
        with open(self.file, "a") as file:
            file.write(f"{os.getpid()}\n")


def who(job, counted):
    assert counted.file
    return os.getpid()


def test_what_jobs_share_is_opened_once_in_each_process(processes, tmp_path):
    file = tmp_path / "opened"
    work = Work(processes)
    pids = {*work.map(who, range(40), Counted(file)), *work.map(who, range(40), Counted(file))}
    assert os.getpid() not in pids
    lines = file.read_text().split()
    assert set(lines) <= {str(pid) for pid in pids}
    assert len(lines) <= 2 * len(pids)


def inner(job, work):
    return work.map(product, range(3), job)


def test_a_job_that_hands_out_jobs_does_them_itself():
    """Else the only thread waited for itself."""
    with ThreadPoolExecutor(1) as pool:
        work = Work(pool)
        assert work.map(inner, range(2), work) == [[0, 0, 0], [0, 1, 2]]


def failing(job, done):
    done.append(job)
    time.sleep(0.01)
    raise ZeroDivisionError(job)


@pytest.mark.parametrize("number", [0, 2])
def test_after_an_error_no_job_is_begun(number):
    done = []
    with ThreadPoolExecutor(2) as pool, pytest.raises(ZeroDivisionError):
        Work(pool if number else None).map(failing, range(100), done)
    assert len(done) < 20


def waiting(job, free):
    return free.wait(30.0)


def test_what_is_cancelled_waits_for_nobody(threads):
    free, stop = threading.Event(), threading.Event()
    work = Work(threads, cancel=stop)
    work.check()
    threading.Timer(0.1, stop.set).start()
    began = time.monotonic()
    try:
        with pytest.raises(Cancelled):
            work.map(waiting, range(9), free)
        assert time.monotonic() - began < 1.0
    finally:
        free.set()
    with pytest.raises(Cancelled):
        work.report("a stage", 1, 2)
    work.wind_up()
    assert work.map(product, range(3), 2) == [0, 2, 4]


def told_at(stage, stop):
    """Progress that stops the work at the first job of a stage in a later round."""
    rounds = []

    def progress(now, done, total, best):
        if (now, done) == (stage, 1):
            rounds.append(best)
            if len(rounds) == 2:
                stop.set()

    return progress, rounds


@dataclass(frozen=True)
class Some(DamperForward):
    """The force of the damper, with these effects as candidates."""

    names: tuple[str, ...] = ("coulomb_friction", "preload", "gas_spring")

    def candidates(self, model):
        return tuple(model.catalogue[name] for name in self.names)


def searched(work):
    """A diagnosis of a damper with friction and a larger offset, among few effects."""
    model, problem = problem_of(
        "coulomb_friction", {"F_c": 2.0, "v_0": 0.002}, 8.0, bent=lambda force, _: force + 4.0
    )
    problem = replace(problem, forward=Some(), noted={}, work=work)
    return search_effects(model, problem), problem


@pytest.fixture
def own(monkeypatch):
    """The lab's own processes, two of them."""
    monkeypatch.setattr(own_processes, "cores", lambda: 3)
    made = own_processes.Processes()
    made.start(made_ready, load_model(GUO))
    while made.room < 4:
        time.sleep(0.05)
    yield made
    made.shutdown()


@pytest.mark.slow
def test_a_diagnosis_is_the_same_whoever_does_it(threads, processes, own):
    expected, serial = searched(HERE)
    assert set(expected.effects) == {"preload", "coulomb_friction"}
    for pool in (threads, processes, own):
        found, problem = searched(Work(pool))
        assert (found.verdict, found.reasons) == (expected.verdict, expected.reasons)
        np.testing.assert_array_equal(found.best.fit.theta, expected.best.fit.theta)
        np.testing.assert_array_equal(found.best.residual, expected.best.residual)
        np.testing.assert_array_equal(found.null.maxima, expected.null.maxima)
        assert found.floor == expected.floor
        assert problem.noted == serial.noted  # of what was fitted elsewhere, too
        assert found.model.catalogue is CATALOGUE


def test_a_search_that_is_cancelled_keeps_what_it_has():
    stop = threading.Event()
    progress, rounds = told_at(TRYING, stop)
    found, problem = searched(Work(progress=progress, cancel=stop))
    assert len(rounds) == 2
    assert found.interrupted
    assert found.effects == ("preload",)
    assert isinstance(rounds[1][0], Leader)
    assert fit(found.model, problem).iterations  # what was done is still made a result of


def test_a_search_that_is_cancelled_before_it_has_anything_says_so():
    stop = threading.Event()
    stop.set()
    with pytest.raises(Cancelled):
        searched(Work(cancel=stop))


OWN = '''
from er_models.effect import Effect, Param, Signature

def force(K: float, v: float) -> float:
    """Force [N]."""
    return K * v * abs(v)

EFFECT = Effect(
    name="of_my_own", stage="force", title="T", physics="P",
    parameters=(Param("K", "N s2/m2", 0.0, 10.0, 0.0, (0.1,), "m"),), hooks={"force": force},
    signature=Signature("m", "force-velocity", "e"), source="s",
)
'''


def seen_of(job, catalogue):
    """What another process knows of an effect."""
    import inspect

    effect = catalogue[job]
    return os.getpid(), inspect.getsource(effect.hooks["force"]), catalogue.origins[job].digest


def test_an_effect_of_a_users_own_travels_with_its_source(processes, tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(OWN, encoding="utf-8")
    catalogue = effects([file])
    expected = seen_of("of_my_own", catalogue)
    file.unlink()
    assert pickle.loads(pickle.dumps(catalogue)) is catalogue
    found = Work(processes).map(seen_of, ["of_my_own"] * 2, catalogue)
    for pid, source, digest in found:
        assert pid != os.getpid()
        assert (source, digest) == expected[1:]


def test_what_cannot_be_sent_is_done_here(processes):
    made = CATALOGUE.extended([])
    with pytest.raises(TypeError):
        pickle.dumps(made)
    assert (
        Work(processes).map(who, range(2), type("Here", (), {"file": made})()) == [os.getpid()] * 2
    )


def test_records_are_fused_the_same_by_whoever_does_it(processes):
    rng = np.random.default_rng(0)
    records = []
    for k in range(3):
        x, v, a, u = imposed(rng, 600)
        noisy = {"deflection": x, "deflection_velocity": v, "sprung_acceleration": a}
        channels = {n: y + 1e-3 * rng.standard_normal(600) for n, y in noisy.items()}
        channels |= {"unsprung_acceleration": 0.0 * a, "duty": u, "damper_force": 9.0 * v}
        records.append(Record(f"run {k}", np.arange(600) * DT, channels))
    data = Dataset.of(records)
    here, there = prepare(data), prepare(data, work=Work(processes))
    np.testing.assert_array_equal(there.motion.v, here.motion.v)
    assert there.fused[1].noise == here.fused[1].noise
    assert there.work.executor is processes
    assert pickle.loads(pickle.dumps(there)).work == HERE


def silent(job, work):
    work.report("of its own", 1, 1)
    return job


def test_a_job_tells_nothing_of_its_own(threads):
    told = []
    work = Work(threads, lambda *words: told.append(words))
    work.map(silent, range(3), work, stage="jobs")
    assert {stage for stage, *_ in told} == {"jobs"}


def test_predictions_that_may_be_cancelled_are_the_same(monkeypatch):
    model, plain = problem_of(None, {}, seed=1, seconds=6.0)
    vectors = model.compiled().p * np.linspace(0.5, 1.5, 7)[:, None]
    watched = replace(plain, work=Work(cancel=threading.Event()))
    monkeypatch.setattr(problem_module, "AT_ONCE", 3 * plain.motion.n)
    monkeypatch.setattr(problem_module, "cores", lambda: 1)
    for rows in (vectors, vectors[:0]):
        np.testing.assert_array_equal(
            watched.predict_many(model, rows), plain.predict_many(model, rows)
        )
    watched.work.cancel.set()
    with pytest.raises(Cancelled):
        watched.predict_many(model, vectors)
