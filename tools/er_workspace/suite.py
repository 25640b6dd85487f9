"""The whole test suite: what computes on all cores first, then what keeps a pace, two at a time."""

from __future__ import annotations

import argparse
import os
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

NOTHING_SELECTED = 5
"""Exit status of pytest where no test was left."""
PACED = "paced"
"""Marker of tests that keep a pace of real time: what computes must not be beside them."""
AT_ONCE = 2
"""Tests that keep a pace and may do so side by side: each waits most of its time."""
ONE_THREAD = dict.fromkeys(("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
"""Environment of tests that have others beside them: every core has its process, threads would only wait."""


def runs(args: Sequence[str], cores: int) -> list[tuple[list[str], Mapping[str, str]]]:
    """Arguments and environment of the runs that make up the suite.

    Whoever says how many processes there shall be gets one run. Files go out in their order, not those with most
    tests first: the few long ones, which start processes, are in `test` and must not be left for the end.
    """
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("-m", dest="marked")
    parser.add_argument("-n", "--numprocesses")
    given, others = parser.parse_known_args(list(args))
    if given.numprocesses is not None or cores < 2:
        return [(list(args), {})]
    chosen = f"({given.marked}) and " if given.marked else ""
    by_file = ["--dist", "loadfile", "--no-loadscope-reorder"]
    return [
        ([*others, "-n", str(cores), *by_file, "-m", f"{chosen}not {PACED}"], ONE_THREAD),
        ([*others, "-n", str(AT_ONCE), *by_file, "-m", chosen + PACED], {}),
    ]


def whole(
    python: Path, args: Sequence[str], folders: Sequence[str], env: Mapping[str, str]
) -> int:
    """Run the suite; returns the first exit status that is not success.

    A stop on request (Ctrl-C, a failure under `-x`) ends it at once.
    """
    worst = NOTHING_SELECTED
    for run, threads in runs(args, os.cpu_count() or 1):
        status = subprocess.run(
            [str(python), "-m", "pytest", *run, *folders], env={**env, **threads}, check=False
        ).returncode
        if worst in (0, NOTHING_SELECTED) and status != NOTHING_SELECTED:
            worst = status
        if status < 0 or status == 2 or (status and "-x" in args):
            break
    return worst
