"""The whole test suite: what computes on all cores first, then what times itself, with nothing beside it."""

from __future__ import annotations

import argparse
import os
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

NOTHING_SELECTED = 5
"""Exit status of pytest where no test was left."""
ALONE = "alone"
"""Marker of tests that run with nothing beside them."""
ONE_THREAD = dict.fromkeys(("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
"""Environment of tests that have others beside them: every core has its process, threads would only wait."""


def runs(args: Sequence[str], cores: int) -> list[list[str]]:
    """Arguments of the runs that make up the suite.

    Whoever says how many processes there shall be gets one run. Files go out in their order, not those with most
    tests first: the few long ones, which start processes, are in `test` and must not be left for the end.
    """
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("-m", dest="marked")
    parser.add_argument("-n", "--numprocesses")
    given, others = parser.parse_known_args(list(args))
    if given.numprocesses is not None or cores < 2:
        return [list(args)]
    chosen = f"({given.marked}) and " if given.marked else ""
    beside = ["-n", str(cores), "--dist", "loadfile", "--no-loadscope-reorder"]
    return [[*others, *beside, "-m", f"{chosen}not {ALONE}"], [*others, "-m", chosen + ALONE]]


def whole(
    python: Path, args: Sequence[str], folders: Sequence[str], env: Mapping[str, str]
) -> int:
    """Run the suite; returns the first exit status that is not success.

    A stop on request (Ctrl-C, a failure under `-x`) ends it at once.
    """
    worst = NOTHING_SELECTED
    for run in runs(args, os.cpu_count() or 1):
        threads = ONE_THREAD if "--dist" in run else {}
        status = subprocess.run(
            [str(python), "-m", "pytest", *run, *folders], env={**env, **threads}, check=False
        ).returncode
        if worst in (0, NOTHING_SELECTED) and status != NOTHING_SELECTED:
            worst = status
        if status < 0 or status == 2 or (status and "-x" in args):
            break
    return worst
