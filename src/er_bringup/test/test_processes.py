"""Child processes: prefixed lines, exit statuses, and nobody left behind."""

from __future__ import annotations

import io
import os
import signal
import sys
from pathlib import Path
from time import monotonic, sleep

import pytest
from er_bringup.graph import NodeSpec
from er_bringup.processes import Child, stop, worst
from er_bringup.up import over
from er_models.errors import InputError

from er_bringup import up

pytestmark = pytest.mark.alone


def child(code: str, out: io.StringIO | None = None, label: str = "node") -> Child:
    """A Python program as a child."""
    return Child(label, [sys.executable, "-u", "-c", code], out or io.StringIO())


def ended(one: Child, seconds: float = 10.0) -> int:
    """Exit status once it has ended."""
    until = monotonic() + seconds
    while one.status is None:
        assert monotonic() < until
        sleep(0.01)
    one.finish()
    return one.status


def said(out: io.StringIO, word: str) -> str:
    """What was printed, once the word is in it."""
    until = monotonic() + 10.0
    while word not in out.getvalue():
        assert monotonic() < until, out.getvalue()
        sleep(0.01)
    return out.getvalue()


def test_lines_carry_the_label() -> None:
    out = io.StringIO()
    one = child("import sys; print('a'); print('b', file=sys.stderr)", out, "plant")
    assert ended(one) == 0
    assert sorted(out.getvalue().splitlines()) == ["[plant] a", "[plant] b"]


def test_a_child_that_nobody_reads_does_not_wait() -> None:
    gone = io.StringIO()
    gone.close()
    assert ended(child("for i in range(20000): print('many words', i)", gone)) == 0


def test_a_program_that_the_system_does_not_start_is_one_line(tmp_path: Path) -> None:
    program = tmp_path / "node"
    program.write_text('#!"/no/such place/python"\n')
    program.chmod(0o755)
    with pytest.raises(InputError, match=r"node: expected a program .*'No such file") as caught:
        Child("node", [str(program)], io.StringIO())
    assert caught.value.exit_status == 2


@pytest.mark.parametrize(
    ("statuses", "reason"),
    [
        ({"plant": None, "recorder": None}, ""),
        ({"plant": None, "recorder": 0}, ""),
        ({"plant": None, "recorder": 137}, ""),
        ({"plant": None, "recorder": 2}, "recorder ended with exit status 2"),
        ({"plant": 0, "recorder": None}, "plant ended"),
        ({"plant": 139, "recorder": None}, "plant was ended by SIGSEGV"),
        ({"plant": 0, "recorder": 1}, "recorder ended with exit status 1"),
    ],
)
def test_the_graph_says_why_it_is_over(statuses: dict[str, int | None], reason: str) -> None:
    assert over(statuses, {"plant"}) == reason


def test_a_graph_of_several_plants_ends_with_the_last() -> None:
    plants = {"a/plant", "b/plant"}
    assert over({"a/plant": 0, "b/plant": None}, plants) == ""
    assert over({"a/plant": 0, "b/plant": 0}, plants) == "a/plant ended, b/plant ended"
    assert over({"observer": 0}, set()) == "everybody has ended"


def test_a_killed_node_is_said_at_once_and_once_and_the_others_go_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    programs = {
        "observer": "import os; os.kill(os.getpid(), 9)",
        "plant": "import time; time.sleep(1.5)",
    }
    specs = [NodeSpec("er_plant_sim", name, "") for name in programs]
    monkeypatch.setattr(up, "nodes", lambda *_: specs)
    monkeypatch.setattr(up, "argv", lambda spec: [sys.executable, "-c", programs[spec.executable]])
    out = io.StringIO()
    assert up.run({}, out) == {"observer": 137, "plant": 0}
    assert out.getvalue().splitlines() == [
        "[er up] observer was ended by SIGKILL: the others go on without it",
        "[er up] plant ended: everything is stopped",
    ]


def test_a_node_that_ends_badly_is_started_again_where_that_is_asked_for(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    mark = tmp_path / "mark"
    once = f"import os, time; p = {str(mark)!r}; x = os.path.exists(p); open(p, 'w'); x or os.kill(os.getpid(), 9)"
    programs = {
        "observer": f"{once}; time.sleep(9)",
        "recorder": "raise SystemExit(0)",
        "plant": "import time; time.sleep(1.0)",
    }
    specs = [NodeSpec("er_plant_sim", name, "") for name in programs]
    monkeypatch.setattr(up, "nodes", lambda *_: specs)
    monkeypatch.setattr(up, "argv", lambda spec: [sys.executable, "-c", programs[spec.executable]])
    monkeypatch.setattr(up, "RESPAWN", 0.1)
    out = io.StringIO()
    assert up.run({"respawn": "true"}, out)["plant"] == 0
    lines = [line for line in out.getvalue().splitlines() if line.startswith("[er up]")]
    assert lines[:2] == [
        "[er up] observer was ended by SIGKILL: the others go on without it",
        "[er up] observer is started again",
    ]
    assert len(lines) == 3


@pytest.mark.parametrize(
    ("code", "status"),
    [("raise SystemExit(3)", 3), ("import os; os.kill(os.getpid(), 9)", 128 + 9)],
)
def test_exit_statuses_are_those_of_a_shell(code: str, status: int) -> None:
    assert ended(child(code)) == status


def test_ctrl_c_is_enough_for_a_good_node() -> None:
    good = (
        "import signal, sys, time\nsignal.signal(signal.SIGINT, lambda *_: sys.exit(0))\n"
        "signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))\nprint('ready')\ntime.sleep(60)"
    )
    one = child(good, out := io.StringIO())
    said(out, "ready")
    stop([one])
    assert one.status == 0


def test_a_node_that_is_still_being_imported_ends_without_a_traceback() -> None:
    out = io.StringIO()
    one = child("import time\nprint('importing')\ntime.sleep(60)", out)
    said(out, "importing")
    stop([one])
    assert one.status == 0
    assert out.getvalue() == "[node] importing\n"


def test_a_node_that_ends_by_a_signal_of_others_has_its_status() -> None:
    one = child("import os, signal; os.kill(os.getpid(), signal.SIGTERM)")
    assert ended(one) == 143
    stop([one])
    assert one.status == 143


def test_a_deaf_node_and_its_children_are_killed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("er_bringup.processes.PATIENCE", 0.2)
    monkeypatch.setattr("er_bringup.processes.LAST_PATIENCE", 0.2)
    deaf = (
        "import signal, subprocess, sys, time\n"
        "for n in (signal.SIGINT, signal.SIGTERM): signal.signal(n, signal.SIG_IGN)\n"
        "p = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60)'])\n"
        "print('child', p.pid)\ntime.sleep(60)"
    )
    out = io.StringIO()
    one = child(deaf, out)
    grandchild = int(said(out, "child").split()[-1])
    stop([one])
    assert one.status == 128 + signal.SIGKILL
    until = monotonic() + 5.0
    while _alive(grandchild):
        assert monotonic() < until
        sleep(0.01)


def _alive(pid: int) -> bool:
    """Whether a process runs; one that ended but was not waited for does not."""
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_the_kernel_ends_a_child_whose_parent_was_killed() -> None:
    code = (
        "import io, sys, time\nfrom er_bringup.processes import Child\n"
        "c = Child('x', [sys.executable, '-c', 'import time; time.sleep(60)'], io.StringIO())\n"
        "print('pid', c.process.pid)\ntime.sleep(60)"
    )
    out = io.StringIO()
    parent = child(code, out)
    grandchild = int(said(out, "pid").split()[-1])
    assert _alive(grandchild)
    os.kill(parent.process.pid, signal.SIGKILL)
    assert ended(parent) == 128 + signal.SIGKILL
    until = monotonic() + 5.0
    while _alive(grandchild):
        assert monotonic() < until
        sleep(0.01)


def test_the_worst_status_counts() -> None:
    assert worst({"a": 0, "b": 2, "c": 0}) == 2
    assert worst({}) == 0
