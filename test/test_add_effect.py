"""An effect is added in a copy of the sources as CONTRIBUTING.md says, word for word, and the contract runs on it."""

import os
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from test.conftest import ROOT

pytestmark = pytest.mark.slow

NAME = "my_orifice"
STEP = re.compile(r"^\d\. `([^`]+)`.*?^ +```(?:python|text)\n(.*?)^ +```$", re.M | re.S)
"""A numbered step: the file it begins with, and the first text that it shows."""
COPIED = (
    "pyproject.toml", "config", "src/er_models", "test/__init__.py", "test/conftest.py", "test/blind",
    "test/test_blind_truths.py",
)  # fmt: skip
MODELS = "src/er_models/test"
NOTICED = (
    f"{MODELS}/test_effect_contract.py::test_every_module_of_the_folders_is_listed",
    f"{MODELS}/test_effect_values.py::test_every_effect_has_its_file",
    "test/test_blind_truths.py",
)
"""Tests that miss a step that was left out; none of them compiles anything."""
CONTRACT = tuple(
    f"{MODELS}/test_effect_{part}.py" for part in ("contract", "values", "mutants", "recovery")
)
TRUTH = ("test/blind/test_effects.py",)


def steps():
    """Files and texts of the section of CONTRIBUTING.md, in order."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    section = text.partition("## Add an effect\n")[2].partition("\n## ")[0]
    return [(Path(file), textwrap.dedent(block)) for file, block in STEP.findall(section)]


def follow(copy, left_out=None):
    """Take the steps; a new file is written, a file that is there gets a line at the end of its list."""
    for k, (file, text) in enumerate(steps()):
        if k == left_out:
            continue
        path = copy / file
        if path.exists():
            head, closing, rest = path.read_text(encoding="utf-8").partition("\n)\n")
            text = head + "\n" + textwrap.indent(text.rstrip(), "    ") + closing + rest
        path.write_text(text, encoding="utf-8")


def few(copy):
    """Leave only the damper, the car and the new effect with its rival: a third of the time to compile."""
    path = copy / "src/er_models/er_models/catalogue/__init__.py"
    kept = re.compile(
        rf'    "(core\.|vehicle\.quarter_car|force\.quadratic_damping|force\.{NAME})'
    )
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    listed = re.compile(r'    "\w+\.\w+",$')
    path.write_text(
        "".join(x for x in lines if kept.match(x) or not listed.match(x)), encoding="utf-8"
    )


@pytest.fixture
def copy(tmp_path):
    """The sources that the steps touch and the contract needs."""
    for name in COPIED:
        source, target = ROOT / name, tmp_path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            shutil.copytree(
                source, target, symlinks=True, ignore=shutil.ignore_patterns("__pycache__")
            )
        else:
            shutil.copy(source, target)
    return tmp_path


def run(copy, tool, *words):
    """Whether a tool is content with a copy, and what it says."""
    path = os.pathsep.join(
        [str(copy / "src/er_models"), *filter(None, [os.environ.get("PYTHONPATH")])]
    )
    done = subprocess.run(
        [sys.executable, "-m", tool, *words],
        cwd=copy,
        env={**os.environ, "PYTHONPATH": path, "ER_CACHE_DIR": str(copy / "cache")},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]


def suite(copy, *words):
    """The same of its tests."""
    return run(copy, "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", *words)


def test_it_takes_four_files():
    names = [file.as_posix() for file, _ in steps()]
    assert len(names) == len(set(names)) == 4
    assert "Four files:" in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    assert [(ROOT / name).exists() for name in names] == [False, True, False, False]


def test_an_effect_that_is_added_as_described_keeps_the_contract(copy):
    follow(copy)
    for style in (("check",), ("format", "--check")):
        passed, said = run(copy, "ruff", *style, "--no-cache", ".")
        assert passed, said
    passed, said = suite(copy, *NOTICED)
    assert passed, said
    few(copy)
    passed, said = suite(copy, *CONTRACT, *TRUTH, "-k", NAME)
    assert passed, said
    assert int(re.search(r"(\d+) passed", said)[1]) > 20, said


@pytest.mark.parametrize("left_out", range(4))
def test_a_step_that_is_left_out_is_missed(copy, left_out):
    follow(copy, left_out)
    assert suite(copy, *NOTICED)[0] is False
