"""How `./er test` runs the whole suite, and what `./er` builds again."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from test.conftest import ROOT

sys.path.insert(0, str(ROOT / "tools"))

from er_workspace import colcon
from er_workspace.layout import Layout
from er_workspace.suite import MACHINE_TIME, ONE_THREAD, SPOILT, runs, timed, whole

from test import machine_time
from test.machine_time import Ledger, times


def test_the_suite_is_run_beside_and_alone() -> None:
    """Tests that time themselves get the machine to themselves; choices hold in both runs."""
    beside, alone = runs(["-q", "-m", "hard"], cores=2)
    workers = ["-n", "3", "--dist", "loadfile", "--no-loadscope-reorder"]
    assert beside == ["-q", *workers, "-m", "(hard) and not alone"]
    assert alone == ["-q", "-m", "(hard) and alone"]
    assert runs(["-x", "--all"], cores=4)[1] == ["-x", "-m", "alone"]
    assert runs(["--all", "-n", "3"], cores=2) == [["-n", "3"]]
    assert runs(["--all"], cores=1) == [[]]


def test_slow_tests_are_for_those_who_ask_for_all() -> None:
    beside, alone = runs(["-q"], cores=2)
    assert beside[-1] == "not slow and not alone"
    assert alone == ["-q", "-m", "not slow and alone"]
    assert runs(["-n", "3"], cores=2) == [["-n", "3", "-m", "not slow"]]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bodies", "args", "status"),
    [
        (("", ""), [], 0),
        (("assert False", ""), [], 1),
        (("", "assert False"), [], 1),
        (("", ""), ["-k", "nothing_of_this_name"], 5),
        (("", ""), ["-k", "test_second"], 0),
        (("", ""), ["--no-such-option"], 4),
    ],
)
def test_the_suite_fails_where_any_test_fails(
    tmp_path: Path, bodies: tuple[str, str], args: list[str], status: int
) -> None:
    first, second = (body or "pass" for body in bodies)
    (tmp_path / "pytest.ini").write_text(
        "[pytest]\nmarkers =\n  alone: by itself\n  slow: for all\n"
    )
    (tmp_path / "test_it.py").write_text(
        f"import pytest\n\n\ndef test_first():\n    {first}\n\n\n"
        f"@pytest.mark.alone\ndef test_second():\n    {second}\n"
    )
    found = whole(Path(sys.executable), args, [str(tmp_path)], os.environ, wait=0.5)
    assert found == status


CONFTEST = """
import pathlib
from test import machine_time
machine_time.SPOILT, machine_time.CALM = {limit}, 0.5
count = pathlib.Path(__file__).with_name("runs")
def pytest_sessionstart(session):
    count.write_text(count.read_text() + "x" if count.exists() else "x")
"""


def run_pytest(*args: str) -> int:
    """Exit status of pytest."""
    return subprocess.run([sys.executable, "-m", "pytest", *args], check=False).returncode


@pytest.mark.slow
@pytest.mark.parametrize(
    ("limit", "passes_at", "status", "needed"),
    [
        (2.0, 2, 1, 1),  # the machine was ours: a failure is one
        (-1.0, 2, 0, 2),  # it never was: again, until it passes
        (-1.0, 4, 1, 3),  # but not for ever
    ],
)
def test_what_failed_while_others_had_the_machine_is_run_again(
    tmp_path: Path, limit: float, passes_at: int, status: int, needed: int
) -> None:
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    (tmp_path / "conftest.py").write_text(CONFTEST.format(limit=limit))
    (tmp_path / "test_it.py").write_text(
        "import pathlib\nimport pytest\n\n"
        "count = pathlib.Path(__file__).with_name('runs')\n\n"
        "def test_once():\n    pass\n\n"
        "@pytest.mark.parametrize('name', ['a b[c]::d'])\ndef test_late(name):\n"
        f"    assert len(count.read_text()) >= {passes_at}\n"
    )
    assert timed(run_pytest, [str(tmp_path)], wait=0.5) == status
    assert (tmp_path / "runs").read_text() == needed * "x"


def test_a_failure_of_a_calm_moment_is_one(tmp_path: Path) -> None:
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    (tmp_path / "conftest.py").write_text(
        CONFTEST.format(limit=0.5) + "machine_time.Ledger.worst = lambda self, since: self.share\n"
        "machine_time.Ledger.share = 1.0\n"
    )
    (tmp_path / "test_it.py").write_text(
        "from test import machine_time\n\n"
        "def test_spoilt():\n    assert False\n\n"
        "def test_of_a_calm_moment():\n    machine_time.Ledger.share = 0.0\n    assert False\n"
    )
    assert timed(run_pytest, [str(tmp_path)], wait=0.5) == 1
    assert (tmp_path / "runs").read_text() == "x"


def test_the_suite_knows_its_plugin() -> None:
    assert machine_time.__name__ == MACHINE_TIME
    assert machine_time.NOTHING_PROVED == SPOILT


def test_stolen_time_is_that_of_the_periods_since_a_moment() -> None:
    counts = iter([(0.0, 100.0), (0.0, 200.0), (30.0, 300.0), (30.0, 300.0), (32.0, 400.0)])
    ledger = Ledger(lambda: next(counts))
    for now in (1.0, 2.0, 3.0, 4.0):
        ledger.look(now)
    assert ledger.shares == [(1.0, 0.0), (2.0, 0.3), (4.0, 0.02)]
    assert (ledger.worst(0.0), ledger.worst(2.5), ledger.worst(5.0)) == (0.3, 0.02, 0.0)
    stolen, whole_time = times()
    assert 0.0 <= stolen < whole_time


def test_what_has_others_beside_it_uses_one_thread(tmp_path: Path) -> None:
    (tmp_path / "pytest.ini").write_text(
        "[pytest]\nmarkers =\n  alone: by itself\n  slow: for all\n"
    )
    (tmp_path / "test_it.py").write_text(
        "import os\nimport pytest\n\nTHREADS = [os.environ.get(k) for k in "
        + repr(tuple(ONE_THREAD))
        + "]\n\n\n"
        "def test_beside():\n    assert THREADS == ['1'] * 3\n\n\n"
        "@pytest.mark.alone\ndef test_alone():\n    assert THREADS == [None] * 3\n"
    )
    free = {k: v for k, v in os.environ.items() if k not in ONE_THREAD}
    assert whole(Path(sys.executable), [], [str(tmp_path)], free) == 0


def test_a_change_of_any_message_or_service_is_a_change_of_what_is_built(tmp_path: Path) -> None:
    package = tmp_path / "src/er_damper_msgs"
    shutil.copytree(ROOT / "src/er_damper_msgs", package)
    layout = Layout(tmp_path, None)
    listed = re.findall(
        r'"((?:msg|srv|action)/\w+\.\w+)"', (package / "CMakeLists.txt").read_text()
    )
    assert {name.partition("/")[0] for name in listed} == {"msg", "srv", "action"}
    for name in listed:
        before = colcon._content(layout)
        with (package / name).open("a") as file:
            file.write("# changed\n")
        assert colcon._content(layout) != before, name
