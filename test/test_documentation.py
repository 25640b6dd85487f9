"""Every command of the documentation is run as a new user would, with data of the test's own for DATA."""

import re
import shlex
import signal
import subprocess
import time

import numpy as np
import pytest

from test.conftest import ROOT
from test.graph_help import own_domain

pytestmark = pytest.mark.slow
IN_ORDER = ("tutorial.md",)
"""Documents whose commands need those before them: test_tutorial runs them."""
DOCUMENTS = [
    ROOT / "README.md",
    *(path for path in sorted((ROOT / "docs").glob("*.md")) if path.name not in IN_ORDER),
]
BLOCK = re.compile(r"^```(?:sh|bash)\n(.*?)^```", re.M | re.S)
ELSEWHERE = {
    "test": "this very suite",
    "bench": "minutes of measurement",
    "demo": "test_demo",
    "replay": "test_replay, with a recording",
    "lab thesis chapter1": "test_thesis_chapter_1, which computes the chapter once",
    "control compare thesis_6_4_1 --fault leakage": "test_control_command, the very words",
    "exec python -m test.blind_score.alarms": "test_blind_alarms, the very words",
    "exec python -m test.blind_score --kinds singles": "test_blind_score, with other seeds and lengths",
}
"""Beginnings of commands that another test runs."""
MEASURED = ("mts", "shaking", "piston")
"""Folders that a documented command makes from measured data."""
EVERY = 32
"""One measured run in so many is kept: what all of them give is for test_measured."""
ENDLESS = ("run", "record", "up")
"""Commands that may go on until Ctrl-C: they get one after a while and must then end well."""


def elsewhere(words):
    """Whether another test runs a command."""
    return any(words[: len(known)] == known for known in map(str.split, ELSEWHERE))


def commands():
    for path in DOCUMENTS:
        for block in BLOCK.findall(path.read_text(encoding="utf-8")):
            for line in block.replace("\\\n", " ").splitlines():
                words = shlex.split(line, comments=True)
                if words[:1] == ["./er"] and not elsewhere(words[1:]):
                    yield pytest.param(
                        tuple(words[1:]), id=f"{path.name}: {' '.join(words[1:])[:70]}"
                    )


CASES = list({case.values[0]: case for case in commands()}.values())


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with the configuration, measurements called DATA, MORE and RIDE, and files the documents name."""
    from test.sample import write_ride, write_sample

    folder = tmp_path_factory.mktemp("user") / "repository"
    folder.mkdir()
    (folder / "config").symlink_to(ROOT / "config")
    for name, seed in (("DATA", 1), ("MORE", 2)):
        (folder / name).mkdir()
        write_sample(folder / name / "run.csv", seed=seed)
    (folder / "RIDE").mkdir()
    write_ride(folder / "RIDE" / "run.csv", seed=1, seconds=5.0)
    (folder.parent / "shared").symlink_to(ROOT.parent / "shared")
    for name in ("my_damper.yaml", "better.yaml"):
        (folder / name).write_text((ROOT / "config/dampers/inove_guo.yaml").read_text())
    (folder / "next.yaml").write_text((ROOT / "config/experiments/chirp.yaml").read_text())
    return folder


def thin(imported):
    """Leave a part of the measured runs that were just imported; the models need not be good ones here."""
    for folder in {path.parent for path in imported.rglob("*.parquet")}:
        for n, path in enumerate(sorted(folder.glob("*.parquet"))):
            if n % EVERY:
                path.unlink()


@pytest.fixture
def domain():
    """A ROS domain that no other test of this machine has."""
    with own_domain() as env:
        yield env["ROS_DOMAIN_ID"]


@pytest.mark.parametrize("words", CASES)
def test_the_command_works_as_written(words, place, domain, monkeypatch):
    measured = any("shared/data" in w or w.split("/")[0] in MEASURED for w in words)
    if measured and not (ROOT.parent / "shared" / "data").is_dir():
        pytest.skip("the measured data are not beside the repository")
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    process = subprocess.Popen(
        [str(ROOT / "er"), *words],
        cwd=ROOT if words[0] == "exec" else place,  # tools of the repository itself run in it
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    if words[0] in ENDLESS and "--help" not in words:
        end = time.monotonic() + 7.0
        while process.poll() is None and time.monotonic() < end:
            time.sleep(0.2)
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=250)
    allowed = (0, 1, 4) if words[0] in ("doctor", "record") else (0,)
    assert process.returncode in allowed, output[-3000:]
    assert "Traceback" not in output, output[-3000:]
    if words[:2] == ("lab", "import"):
        thin(place / words[-1])


def test_the_documents_hold_commands():
    assert len(CASES) > 10
    assert np.unique([p.id for p in CASES]).size == len(CASES)
