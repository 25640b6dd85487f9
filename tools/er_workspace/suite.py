"""The test suite: what computes on all cores first, then what times itself, with nothing beside it.

Tests marked `slow` (whole documents, tutorials, statistics) are for `--all`, which the workflow of every night runs.
Of the latter, tests that failed while others had the machine, as the kernel counted it, are run again
(`test/machine_time.py`): their failure says nothing. There simulated worlds go slower than real time, where a test
can do with that. What fails on a machine that is left to it fails the suite.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

NOTHING_SELECTED = 5
"""Exit status of pytest where no test was left."""
ALONE, SLOW = "alone", "slow"
"""Markers of tests that run with nothing beside them, and of those that only `--all` runs."""
MACHINE_TIME, SPOILT = "test.machine_time", 75
"""Plugin that tells whose time it was, and its exit status where nothing but spoilt tests failed."""
AGAIN, WAIT = (0.5, 0.25), 60
"""Paces of simulated worlds when spoilt tests are run again; how long a calm machine is waited for each time [s]."""
ONE_THREAD = dict.fromkeys(("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
"""Environment of tests that have others beside them: every core has its process, threads would only wait."""


def runs(args: Sequence[str], cores: int) -> list[list[str]]:
    """Arguments of the runs that make up the suite; of two, the second has nothing beside it.

    Whoever says how many processes there shall be gets one run; whoever names a marker gets its slow tests, too. Files
    go out in their order, not those with most tests first: the few long ones, which start processes, are in
    `test` and must not be left for the end.
    """
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("-m", dest="marked")
    parser.add_argument("-n", "--numprocesses")
    parser.add_argument("--all", action="store_true")
    given, others = parser.parse_known_args(list(args))
    chosen = f"({given.marked})" if given.marked else ""
    if not (given.all or chosen):
        chosen = f"not {SLOW}"
    if given.numprocesses is not None or cores < 2:
        once = [] if given.numprocesses is None else ["-n", given.numprocesses]
        return [[*others, *once, *(["-m", chosen] if chosen else [])]]
    workers = cores + 1  # what starts programs often waits for them
    beside = ["-n", str(workers), "--dist", "loadfile", "--no-loadscope-reorder"]
    chosen = f"{chosen} and " if chosen else ""
    return [[*others, *beside, "-m", f"{chosen}not {ALONE}"], [*others, "-m", chosen + ALONE]]


def whole(
    python: Path,
    args: Sequence[str],
    folders: Sequence[str],
    env: Mapping[str, str],
    wait: float = WAIT,
) -> int:
    """Run the suite; returns the first exit status that is not success.

    wait: how long a calm machine is waited for where tests failed while others had it [s].

    A stop on request (Ctrl-C, a failure under `-x`) ends it at once.
    """
    worst = NOTHING_SELECTED

    def tested(*args: str) -> int:
        threads = ONE_THREAD if "--dist" in args else {}
        command = [str(python), "-m", "pytest", *args]
        return subprocess.run(command, env={**env, **threads}, check=False).returncode

    for place, run in enumerate(runs(args, os.cpu_count() or 1)):
        status = timed(tested, [*run, *folders], wait) if place else tested(*run, *folders)
        if worst in (0, NOTHING_SELECTED) and status != NOTHING_SELECTED:
            worst = status
        if status < 0 or status == 2 or (status and "-x" in args):
            break
    return worst


def timed(tested: Callable[..., int], run: Sequence[str], wait: float = WAIT) -> int:
    """Run what times itself, again where the machine was not ours; returns the exit status.

    tested: runs pytest; wait: how long a calm machine is waited for [s].
    """
    with TemporaryDirectory() as folder:
        spoilt = Path(folder) / "spoilt"
        watched = ["-p", MACHINE_TIME, "--spoilt", str(spoilt)]
        status = tested(*run, *watched)
        for pace in AGAIN:
            if status != SPOILT:
                return status
            tests = spoilt.read_text(encoding="utf-8").splitlines()
            sys.stdout.write(
                f"er: {len(tests)} failed while others had the machine: run again once it is calm\n"
            )
            sys.stdout.flush()
            status = tested(*watched, "--calm", str(wait), "--pace", str(pace), *tests)
        return 1 if status == SPOILT else status
