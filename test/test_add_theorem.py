"""A theorem and its observer, added in a copy by following CONTRIBUTING.md: everything else follows.

The copy holds what the steps touch; what they do not is read where it is, so that nothing is compiled anew.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from textwrap import dedent

import pytest

pytest.importorskip("rclpy")

from er_observers.programs import OBSERVERS

from test.conftest import ROOT

pytestmark = pytest.mark.slow

NAME = "one_gain"
CHAPTER = re.search(
    r"## Add a theorem\n(.*?)\n## ", (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"), re.S
)
MOST = 6
"""Files that a theorem with its observer may cost."""
PACKAGE = "src/er_observers"
CODE = f"{PACKAGE}/er_observers"
COPIED = (
    f"{CODE}/programs.py", f"{CODE}/synthesis", f"{PACKAGE}/setup.py", f"{PACKAGE}/package.xml",
    f"{PACKAGE}/test/conftest.py", f"{PACKAGE}/test/test_observer_theorems.py", "config",
)  # fmt: skip
OVERLAY = f"""
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
import er_observers.synthesis

code = Path(__file__).parent / "{CODE}"
er_observers.synthesis.__path__ = [str(code / "synthesis")]
spec = spec_from_file_location("er_observers.programs", code / "programs.py")
er_observers.programs = sys.modules[spec.name] = module_from_spec(spec)
spec.loader.exec_module(er_observers.programs)
"""
"""Reads the rest of the package where it is: the digest that compiled code is named after stays."""
SEEN = """
import json, sys
from pathlib import Path
import yaml
from er_bringup.arguments import ARGUMENTS
from er_bringup.cores import entry
from er_bringup.given import parse
from er_bringup.graph import nodes
from er_bringup.integration.write import files
from er_bringup.ros_composed import part
from er_common.parameter_table import build
from er_common.topics import ACCELERATION, PWM_APPLIED
from er_ros_common import builders
from er_ros_common.core import When

config, name = Path("config").absolute(), sys.argv[1]
spec = next(s for s in nodes(parse([f"observers:={name}", "record:=bag"]), config) if name in s.executable)
recorder = nodes(parse(["record:=bag"]), config)[0]
shell = entry(spec.executable)
(given,) = (yaml.safe_load(Path(file).read_text())["/**"]["ros__parameters"] for file in spec.files)
core = shell.make(build(shell.parameters, given | dict(spec.parameters), {}))
state, said = core.start(), []
for k in range(1, 40):
    tick, when = builders.Tick(5_000_000 * k, k), When(5_000_000 * k, None)
    for topic, message in (
        (ACCELERATION, builders.suspension_acceleration(tick, 0.1, -0.2)),
        (PWM_APPLIED, builders.pwm_duty(tick, 0.1)),
    ):
        state, answers = core.on_message(state, topic, message, when)
        said += answers
report = core.report(state)
print(json.dumps({
    "file": spec.files[0], "gains": spec.parameters["gains_file"], "sources": recorder.parameters["sources"],
    "default": next(a.default for a in ARGUMENTS if a.name == "observers"),
    "said": sorted({topic.name for topic, _ in said}), "answers": len(said), "mode": report.mode,
    "help": part([f"er_observers/{spec.executable}"]).executable.card.program.text,
    "recorded": files()["recording/qos_overrides.yaml"], "shown": files()["layouts/plotjuggler.xml"],
}))
"""


def blocks(kind: str) -> list[str]:
    """Code of this kind in the chapter, in order."""
    assert CHAPTER is not None
    return [
        dedent(text)
        for text in re.findall(rf"^   ```{kind}\n(.*?)^   ```$", CHAPTER[1], re.M | re.S)
    ]


def inserted(path: Path, before: str, row: str) -> None:
    """Put a row of a table before the only line that begins so."""
    text = path.read_text(encoding="utf-8")
    assert text.count(before) == 1, (path, before)
    path.write_text(text.replace(before, f"{row}{before}"), encoding="utf-8")


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The copy after the steps, with gains."""
    copy = tmp_path_factory.mktemp("copy")
    for name in COPIED:
        (copy / name).parent.mkdir(parents=True, exist_ok=True)
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(ROOT / name, copy / name)
    (copy / "overlay.py").write_text(OVERLAY, encoding="utf-8")
    (theorem,), (row, shape), (parameters,) = (blocks(kind) for kind in ("python", "text", "yaml"))
    (copy / CODE / f"synthesis/{NAME}.py").write_text(theorem, encoding="utf-8")
    inserted(copy / CODE / "programs.py", "    FAULT_ESTIMATOR,\n", f"    {row}")
    (copy / f"config/nodes/{NAME}_observer.yaml").write_text(parameters, encoding="utf-8")
    tests = copy / f"{PACKAGE}/test/test_observer_theorems.py"
    inserted(tests, "}\n\n\n@pytest.mark.parametrize", f"    {shape}")
    (synth, *_) = blocks("sh")[0].splitlines()
    words = synth.split()
    assert words[:2] == ["./er", "synth"]
    run(copy, "-c", "import overlay, er_observers.synth as s; s.main()", *words[2:])
    return copy


def run(copy: Path, *command: str) -> str:
    """Output of Python in the copy."""
    places = os.pathsep.join([str(copy), *filter(None, sys.path)])
    done = subprocess.run(
        [sys.executable, *command], cwd=copy, env=os.environ | {"PYTHONPATH": places}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    return done.stdout


def test_so_many_files_are_touched_as_the_chapter_says(copy: Path) -> None:
    touched = set()
    for path in copy.rglob("*"):
        name = path.relative_to(copy)
        if not path.is_file() or "__pycache__" in name.parts or name.name == "overlay.py":
            continue
        if not (ROOT / name).is_file() or (ROOT / name).read_bytes() != path.read_bytes():
            touched.add(str(name))
    touched -= {f"config/gains/{NAME}.yaml"}  # a command writes it
    assert CHAPTER is not None
    assert {name for name in touched if f"`{name}`" not in CHAPTER[1]} == set()
    assert len(touched) == 4
    assert CHAPTER[1].startswith("\nFour files, ")
    assert len(touched) <= MOST


def test_the_observer_is_there(copy: Path) -> None:
    seen = json.loads(run(copy, "-c", f"import overlay\n{SEEN}", NAME).splitlines()[-1])
    assert seen["file"] == str(copy / f"config/nodes/{NAME}_observer.yaml")
    assert seen["gains"] == str(copy / f"config/gains/{NAME}.yaml")
    assert seen["default"].split(",") == [*OBSERVERS, NAME]
    assert f"force/{NAME}" in seen["sources"]
    assert f"/force/{NAME}:" in seen["recorded"]
    assert f"/force/{NAME}/force" in seen["shown"]
    assert seen["said"] == [f"force/{NAME}"]
    assert seen["answers"] > 30
    assert seen["mode"] == "running"
    assert seen["help"].endswith("one gain for every duty.")


def test_its_script_would_be_built(copy: Path) -> None:
    told = "import setuptools; setuptools.setup = lambda **given: print(given['entry_points'])\n"
    code = f"{told}import os, runpy; os.chdir({PACKAGE!r}); runpy.run_path('setup.py')"
    expected = f"{NAME}_observer = er_observers.executables:{NAME}_observer"
    assert expected in run(copy, "-c", code)


def test_the_tests_of_theorems_try_it(copy: Path) -> None:
    found = run(
        copy, "-m", "pytest", "-q", "-p", "overlay", "-p", "no:cacheprovider", "-p", "no:randomly",
        f"{PACKAGE}/test/test_observer_theorems.py", "-k", NAME,
    )  # fmt: skip
    assert "3 passed" in found
