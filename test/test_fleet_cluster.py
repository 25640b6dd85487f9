"""A fleet on a real Dask cluster of processes: what is killed, stopped or of other versions."""

import os
import signal
import time

import psutil
import pyarrow.parquet as parquet
import pytest
from er_model_lab.fleets.asked import Asked, code
from er_model_lab.fleets.cluster import cluster, refuse_others
from er_model_lab.fleets.engine import OtherCode, spread

import er_model_lab as lab
from test.sample import write_sample

pytestmark = pytest.mark.slow
ASKED = Asked(lab.load_model("inove_guo"))


def told_by(job, asked):
    """A job of tests: its number, and the process that does it."""
    time.sleep(0.01)
    return job, os.getpid()


def of_other_versions():
    """Make a worker one of other versions."""
    code()["numpy"] = "0.1"


def workers():
    """Processes that this one started to share its work."""
    return [
        p
        for p in psutil.Process().children(recursive=True)
        if "spawn_main" in " ".join(p.cmdline())
    ]


@pytest.fixture(scope="module")
def engine():
    """Two processes: starting them takes longer than what is done here."""
    with cluster(None, workers=2) as made:
        yield made
    assert workers() == []


def test_a_worker_that_is_killed_costs_nothing(engine):
    found = {}

    def told(number, result):
        assert number not in found
        found[number] = result
        if len(found) == 60:
            os.kill(result[1], signal.SIGKILL)

    spread(engine, told_by, ((k, k) for k in range(400)), ASKED, told, lambda: None)
    assert [found[k][0] for k in range(400)] == [*range(400)]
    engine.executor._client.wait_for_workers(2, timeout=30)  # another came for the one that was killed


def test_ctrl_c_keeps_what_was_done_and_the_next_call_goes_on(engine, tmp_path):
    for k in range(6):
        write_sample(tmp_path / f"{k}.csv", seed=k, seconds=3.0)
    asked = {"out": tmp_path / "fleet.parquet", "by": "file", "search": False}
    data, model = str(tmp_path / "*.csv"), lab.load_model("inove_guo")

    def stop(stage, done, total, _):
        if done == 3:
            for process in (*workers(), psutil.Process()):
                process.send_signal(signal.SIGINT)

    first = lab.fleet(data, model, **asked, executor=engine.executor, progress=stop)
    kept = parquet.read_table(first.recordings_table).num_rows
    assert first.interrupted
    assert 3 <= kept < 6
    assert "resume=True goes on" in first.notes[0]
    second = lab.fleet(data, model, **asked, resume=True, executor=engine.executor)
    assert (second.to_dict()["reused"], second.to_dict()["statuses"]) == (kept, {"used": 6})


def test_workers_of_other_versions_are_refused_by_name(engine):
    client = engine.executor._client
    refuse_others(client)
    client.run(of_other_versions)
    with pytest.raises(OtherCode, match=r"worker tcp://\S+ has numpy 0\.1 instead of"):
        refuse_others(client)
    with pytest.raises(OtherCode, match="numpy"):
        spread(engine, told_by, iter([(0, 0)]), ASKED, print, lambda: None)
