"""A fleet on a real Dask cluster of processes: what is killed, stopped or of other versions."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import time

import psutil
import pyarrow.parquet as pq
import pytest
from distributed import Security
from er_model_lab.fleets.asked import Asked, code
from er_model_lab.fleets.cluster import cluster, refuse_others
from er_model_lab.fleets.engine import OtherCode, spread
from er_studies.bench.fleet.data import fleet
from er_studies.bench.fleet.measure import Loop

import er_model_lab as lab

pytestmark = pytest.mark.slow
ASKED = Asked(lab.load_model("inove_guo"))


def told_by(job, asked):
    """A job of tests: its number, and the process that does it."""
    time.sleep(0.01)
    return job, os.getpid()


def of_other_versions():
    """Make a worker one of other versions."""
    code()["numpy"] = "0.1"


def ignores_ctrl_c():
    """Whether a worker leaves it to who asks."""
    return signal.getsignal(signal.SIGINT) is signal.SIG_IGN


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
    engine.executor._client.wait_for_workers(
        2, timeout=30
    )  # another came for the one that was killed


def test_ctrl_c_ends_a_run_and_no_worker(engine):
    """A terminal sends it to all processes."""
    engine.executor._client.wait_for_workers(2, timeout=60)
    assert [*engine.executor._client.run(ignores_ctrl_c).values()] == [True, True]
    before, found = {p.pid for p in workers()}, []

    def told(number, result):
        found.append(number)
        if len(found) == 20:
            for process in (*workers(), psutil.Process()):
                process.send_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        spread(engine, told_by, ((k, k) for k in range(400)), ASKED, told, lambda: None)
    assert 20 <= len(found) < 400
    again = {}
    spread(engine, told_by, ((k, k) for k in range(40)), ASKED, again.__setitem__, lambda: None)
    assert again.keys() == {*range(40)}
    assert {p.pid for p in workers()} == before


def test_workers_of_other_versions_are_refused_by_name(engine):
    client = engine.executor._client
    refuse_others(client)
    client.run(of_other_versions)
    with pytest.raises(OtherCode, match=r"worker tcp://\S+ has numpy 0\.1 instead of"):
        refuse_others(client)
    with pytest.raises(OtherCode, match="numpy"):
        spread(engine, told_by, iter([(0, 0)]), ASKED, print, lambda: None)


CLIENT = """
import sys
import er_model_lab as lab

if __name__ == "__main__":
    lab.fleet(
        sys.argv[1], lab.load_model("inove_guo"), out=sys.argv[2], search=False, workers=1,
        progress=lambda *words: print(*words, flush=True),
    )
"""


def test_a_client_that_is_killed_loses_nothing(tmp_path):
    """What it had told of is kept, and its workers end by themselves."""
    model = lab.load_model("inove_guo")
    fleet(model, tmp_path / "data", units=2, recordings=4, seconds=5.0, seed=3)
    (tmp_path / "client.py").write_text(CLIENT)
    table, words = tmp_path / "fleet.parquet", [sys.executable, tmp_path / "client.py"]
    client = subprocess.Popen(
        [*words, tmp_path / "data", table], stdout=subprocess.PIPE, text=True
    )
    told = [client.stdout.readline() for _ in range(3)]
    left = psutil.Process(client.pid).children(recursive=True)
    client.kill()
    client.wait()
    assert left
    assert all(told), told
    again = lab.fleet(
        tmp_path / "data", model, out=table, search=False, resume=True, executor=Loop()
    )
    assert 2 <= again.to_dict()["reused"] < 8
    assert pq.read_table(table)["unit"].to_pylist() == ["unit0000", "unit0001"]
    assert psutil.wait_procs(left, timeout=60)[1] == []


CERTIFICATE = ("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=fleet")


def started(kind, *words):
    """A scheduler or worker of its own, as on a cluster."""
    command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *words]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


@pytest.mark.skipif(shutil.which("openssl") is None, reason="no openssl")
def test_a_scheduler_that_restarts_behind_tls(tmp_path):
    key, pem = tmp_path / "key.pem", tmp_path / "cert.pem"
    subprocess.run(
        ["openssl", *CERTIFICATE, "-keyout", key, "-out", pem], check=True, capture_output=True
    )
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address = f"tls://127.0.0.1:{port}"
    tls = ("--tls-ca-file", pem, "--tls-cert", pem, "--tls-key", key)
    words = ("--host", address, "--no-dashboard", *tls)
    alone = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", tmp_path)
    processes = []

    def start():
        processes[:] = [started("scheduler", *words), started("worker", address, *alone, *tls)]

    security = Security(
        tls_ca_file=str(pem),
        tls_client_cert=str(pem),
        tls_client_key=str(key),
        require_encryption=True,
    )
    found = {}

    def told(number, result):
        assert number not in found
        found[number] = result
        if len(found) == 20:
            for process in processes:
                process.kill()
                process.wait()
            start()

    start()
    try:
        with cluster(address, security=security) as engine:
            spread(engine, told_by, ((k, k) for k in range(120)), ASKED, told, lambda: None)
    finally:
        for process in processes:
            process.kill()
            process.wait()
    assert [found[k][0] for k in range(120)] == [*range(120)]
