"""What belongs to an extra and is not installed: one line that says how to get it, and everything else works."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

WITHOUT = """
import sys

for name in (
    "PIL", "asammdf", "distributed", "h5py", "jinja2", "lz4", "matplotlib", "nicegui", "nptdms", "plotly", "rosbags"
):
    sys.modules[name] = None
from er_model_lab.cli.app import main

main()
"""
MODEL = ("--model", "inove_guo")


def lab(*words: str, cwd: Path) -> tuple[int, str]:
    """Exit status of a command where no extra is installed, and what it said of a failure."""
    command = [sys.executable, "-c", WITHOUT, *words]
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    return done.returncode, done.stderr


@pytest.fixture
def here(tmp_path: Path) -> Path:
    """A folder with something of every kind."""
    rows = "".join(f"{0.005 * k},{1e-4 * (k % 80)},0.1,{k % 7}\n" for k in range(400))
    (tmp_path / "run.csv").write_text(f"t,deflection,duty,damper_force\n{rows}")
    (tmp_path / "run.mcap").write_text("some")
    (tmp_path / "run.mf4").write_text("MDF     4.10")
    (tmp_path / "run.mat").write_bytes(b"\x89HDF\r\n\x1a\n")
    (tmp_path / "run.tdms").write_text("TDSm")
    return tmp_path


JINJA = "a report needs the Python package jinja2: pip install 'er_model_lab[plots]'"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("check", "run.mcap"), "run.mcap: a bag needs the Python package rosbags: pip install 'er_records[bags]'"),
        (("check", "run.mf4"), "run.mf4: MF4 needs the Python package asammdf: pip install 'er_records[mf4]'"),
        (("check", "run.mat"), "run.mat: MATLAB 7.3 needs the Python package h5py: pip install 'er_records[mat]'"),
        (("check", "run.tdms"), "run.tdms: TDMS needs the Python package nptdms: pip install 'er_records[tdms]'"),
        (("compare", "run.csv", *MODEL, "--report", "r"), JINJA),
        (("effects", "preload", "--report", "r"), JINJA),
        (("open", "--no-browser"), "the page needs the Python package nicegui: pip install 'er_model_lab[page]'"),
        (("fleet", "run.csv", *MODEL, "--out", "o.parquet"),
         "a fleet needs the Python package distributed: pip install 'er_model_lab[fleet]'"),
        (("export", "run.csv", *MODEL, "--series", "o.mf4"),
         "MF4 needs the Python package asammdf: pip install 'er_records[mf4]'"),
    ],
    ids=["bag", "mf4", "mat", "tdms", "report", "cards", "page", "fleet", "series"],
)  # fmt: skip
def test_what_is_not_installed_is_one_line(words: tuple[str, ...], said: str, here: Path) -> None:
    assert lab(*words, cwd=here) == (2, f"{said}\n")


def test_a_table_is_read_and_compared_without_any_extra(here: Path) -> None:
    assert lab("compare", "run.csv", *MODEL, cwd=here) == (0, "")
