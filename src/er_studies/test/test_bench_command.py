"""The command that measures speed names what it can measure and refuses the rest."""

from __future__ import annotations

import json
import os
import runpy
import signal
import subprocess
import sys

import pytest
from er_studies.bench import __main__ as bench
from er_studies.bench import wire


@pytest.mark.parametrize("given", [[], ["-h"]])
def test_lists_what_can_be_measured(given, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["er bench", *given])
    with pytest.raises(SystemExit) as stop:
        bench.main()
    assert stop.value.code == 0
    shown = capsys.readouterr().out
    assert all(f"er bench {name}" in shown for name in bench.PARTS)


def test_refuses_another_name(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["er bench", "speed"])
    with pytest.raises(SystemExit) as stop:
        bench.main()
    assert stop.value.code == 2
    assert f"expected one of {', '.join(bench.PARTS)}, found 'speed'" in capsys.readouterr().err


def test_hands_its_arguments_over(monkeypatch):
    run = []
    monkeypatch.setattr(runpy, "run_module", lambda module, **_: run.append(module))
    monkeypatch.setattr("sys.argv", ["er bench", "models", "ride"])
    bench.main()
    assert (run, sys.argv) == (["er_studies.bench.models"], ["er bench models", "ride"])


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_part_that_is_stopped_ends_what_it_began(number, tmp_path):
    (tmp_path / "part.py").write_text(
        # a signal that comes as a sleep begins does not end it
        "import time\ntry:\n    print('began', flush=True)\n    while True:\n        time.sleep(0.1)\n"
        "finally:\n    print('ended', flush=True)\n"
    )
    code = "from er_studies.programs import hand_over; hand_over('er bench', {'part': 'part'}, '')"
    program = subprocess.Popen(
        [sys.executable, "-c", code, "part"],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert program.stdout.readline() == "began\n"
    program.send_signal(number)
    assert program.communicate(timeout=30) == ("ended\n", "er bench part: interrupted\n")
    assert program.returncode == 130


def test_the_machine_is_told_beside_what_was_measured(capsys, tmp_path):
    wire.main(frames=100, turns=1, json_file=tmp_path / "w")
    costs, machine = json.loads((tmp_path / "w").read_text())["tables"]
    assert [row[0] for row in costs["rows"]] == ["plain, CRC-32", "sealed, BLAKE2s"]
    ((cores, _, python),) = machine["rows"]
    assert cores.startswith(f"{os.cpu_count()} cores, Python 3.")
    assert python.split()[1] in ("ms", "s")
    assert f"| {cores} |" in capsys.readouterr().out
