"""The lab's own processes: there where they pay, gone with their owner, and no loss where one of them dies."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from er_model_lab.jobs import processes
from er_model_lab.jobs.processes import PROCESSES, Processes
from er_model_lab.work import WORTH, Cancelled, Work
from threadpoolctl import threadpool_info

TWO_OTHERS = 3
"""Cores that this process is told it has."""


@pytest.fixture
def own(monkeypatch):
    """Two processes, ready."""
    monkeypatch.setattr(processes, "cores", lambda: TWO_OTHERS)
    made = Processes()
    made.start(os.getpid)
    wait_until(lambda: made.room == 4)
    yield made
    made.shutdown()


def wait_until(true, seconds=60.0):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


def alive(pid):
    """Whether a process is there and is no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def slow(job, seconds):
    time.sleep(seconds)
    return job, os.getpid()


def test_this_process_and_the_others_share_the_jobs(own):
    found = Work(own).map(slow, range(24), 0.02)
    assert [job for job, _ in found] == list(range(24))
    pids = {pid for _, pid in found}
    assert len(pids) == 3
    assert os.getpid() in pids
    assert len(list(own.folder.iterdir())) == 2  # what the jobs shared is thrown away


def test_what_is_not_ready_is_not_waited_for(monkeypatch):
    monkeypatch.setattr(processes, "cores", lambda: TWO_OTHERS)
    made = Processes()
    made.start(time.sleep, 20.0)
    try:
        assert {pid for _, pid in Work(made).map(slow, range(3), 0.0)} == {os.getpid()}
    finally:
        made.shutdown()


def dying(job, owner):
    if os.getpid() != owner:
        os._exit(9)
    time.sleep(0.05)
    return job


def test_what_a_process_that_dies_leaves_undone_is_done_here(own):
    assert Work(own).map(dying, range(9), os.getpid()) == list(range(9))
    wait_until(lambda: own.room == 0)
    own.start(os.getpid)
    wait_until(lambda: own.room == 4)


def growing(job):
    time.sleep(0.2)
    if job == LAST:
        kept.append(bytearray(LEAK))  # bytes that are zero take memory only once they are written
        kept[-1][::4096] = b"1" * len(kept[-1][::4096])
        time.sleep(1.5)
    return job


LAST, LEAK = 15, 600_000_000
"""The job that makes its process grow, and by how much [bytes]: from 300 MB on another takes its place."""
kept: list[bytearray] = []


def test_one_that_grew_is_not_counted_beside_the_one_that_takes_its_place(own):
    before = own.ready
    for job in (*range(LAST + 1), *range(9)):
        own.submit(growing, job).result()
    own.submit(os.getpid).result()
    wait_until(lambda: own.ready != before)
    assert own.room == 4


def test_those_who_are_ended_by_another_thread_leave_nothing_undone(own):
    threading.Timer(0.2, own.shutdown).start()
    assert [job for job, _ in Work(own).map(slow, range(12), 0.1)] == list(range(12))


def test_what_is_cancelled_ends_whoever_does_it(own):
    stop = threading.Event()
    pids = {pid for _, pid in Work(own).map(slow, range(24), 0.02)} - {os.getpid()}
    told = []

    def progress(stage, done, total, best):
        told.append(done)
        stop.set()

    began = time.monotonic()
    with pytest.raises(Cancelled):
        Work(own, progress, stop).map(by_who, range(9), os.getpid(), stage="sleeping")
    assert time.monotonic() - began < 1.0
    assert told == [1]
    wait_until(lambda: not any(map(alive, pids)), 2.0)


def by_who(job, owner):
    time.sleep(0.01 if os.getpid() == owner else 30.0)


def failing(job):
    raise ZeroDivisionError(job)


def test_an_error_comes_back(own):
    with pytest.raises(ZeroDivisionError):
        Work(own).map(failing, range(9))


def threads(job):
    import numpy as np

    np.linalg.inv(np.eye(3))
    time.sleep(0.1)
    return [lib["num_threads"] for lib in threadpool_info() if lib["user_api"] == "blas"]


def test_linear_algebra_has_one_thread_there(own):
    found = Work(own).map(threads, range(6))
    assert [1] in found
    futures = [own.submit(threads, 0) for _ in range(4)]
    assert [f.result() for f in futures] == [[1]] * 4


def started(made):
    made.start(os.getpid)
    return made.folder is not None


def test_none_is_started_where_it_would_not_pay(monkeypatch):
    made = Processes()
    monkeypatch.setattr(processes, "cores", lambda: 1)
    assert not started(made)
    monkeypatch.setattr(processes, "cores", lambda: TWO_OTHERS)
    Work(made).expect(WORTH / 2.0, os.getpid)
    assert made.folder is None
    Work(made).expect(2.0 * WORTH, os.getpid)
    assert made.folder is not None
    made.shutdown()


def test_a_process_that_shares_work_starts_none(own):
    assert own.submit(nested, None).result() == (True, False)


def nested(_):
    processes.cores = lambda: TWO_OTHERS
    return multiprocessing.parent_process() is not None, started(Processes())


def test_they_outlive_the_thread_that_started_them(monkeypatch):
    monkeypatch.setattr(processes, "cores", lambda: TWO_OTHERS)
    made = Processes()
    thread = threading.Thread(target=made.start, args=(os.getpid,))
    thread.start()
    thread.join()
    wait_until(lambda: made.room == 4)
    time.sleep(4.0 * processes.LOOK)
    assert made.submit(os.getpid).result() != os.getpid()
    made.shutdown()


SCRIPT = """
import os, sys, time
from er_model_lab.jobs import processes
from er_model_lab.jobs.processes import PROCESSES
from er_model_lab.work import Work

processes.cores = lambda: 3
PROCESSES.start(os.getpid)
while PROCESSES.room < 4:
    time.sleep(0.05)
found = Work(PROCESSES).map(divmod, range(24), 5)
assert found == [divmod(k, 5) for k in range(24)]
print(PROCESSES.folder, *(PROCESSES.submit(os.getpid).result() for _ in range(8)), flush=True)
if len(sys.argv) > 1:
    futures = [PROCESSES.submit(time.sleep, 60.0) for _ in range(2)]
if sys.argv[1:] == ["at once"]:
    PROCESSES.shutdown()
    os._exit(0)
elif len(sys.argv) > 1:
    time.sleep(60.0)
"""


def run(folder, *words):
    """A script that does not guard what it does against being run again."""
    script = folder / "script.py"
    script.write_text(SCRIPT)
    return subprocess.Popen(
        [sys.executable, str(script), *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_a_plain_script_may_use_them_and_leaves_nothing_behind(tmp_path):
    done = run(tmp_path)
    out, err = done.communicate(timeout=120.0)
    assert (done.returncode, err) == (0, "")
    folder, *pids = out.split()
    assert not Path(folder).exists()
    assert not any(alive(int(pid)) for pid in pids)


def test_an_owner_that_ends_at_once_leaves_no_words_of_theirs(tmp_path):
    done = run(tmp_path, "at once")
    _, err = done.communicate(timeout=120.0)
    assert (done.returncode, err) == (0, "")


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_they_end_with_an_owner_that_is_killed(tmp_path):
    owner = run(tmp_path, "stay")
    folder, *pids = owner.stdout.readline().split()
    assert all(alive(int(pid)) for pid in pids)
    os.kill(owner.pid, signal.SIGKILL)
    owner.communicate()
    wait_until(lambda: not any(alive(int(pid)) for pid in pids), 10.0)
    wait_until(lambda: not Path(folder).exists(), 5.0)


def test_those_of_this_process_are_not_started_by_a_test():
    """Tests have others beside them; only what asks for processes starts some."""
    assert PROCESSES.folder is None
