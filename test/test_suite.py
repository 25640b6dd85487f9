"""How `./er test` runs the whole suite, and what `./er` builds again."""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path

import pytest

from test.conftest import ROOT

sys.path.insert(0, str(ROOT / "tools"))

from er_workspace import colcon
from er_workspace.layout import Layout
from er_workspace.suite import ONE_THREAD, runs, whole


def test_the_suite_is_run_beside_and_alone() -> None:
    """Tests that time themselves get the machine to themselves; choices hold in both runs."""
    beside, alone = runs(["-q", "-m", "not slow"], cores=2)
    assert beside == [
        "-q",
        "-n",
        "2",
        "--dist",
        "loadfile",
        "--no-loadscope-reorder",
        "-m",
        "(not slow) and not alone",
    ]
    assert alone == ["-q", "-m", "(not slow) and alone"]
    assert runs(["-x"], cores=4)[1] == ["-x", "-m", "alone"]
    assert runs(["-n", "3"], cores=2) == [["-n", "3"]]
    assert runs(["-q"], cores=1) == [["-q"]]


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
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = alone: by itself\n")
    (tmp_path / "test_it.py").write_text(
        f"import pytest\n\n\ndef test_first():\n    {first}\n\n\n"
        f"@pytest.mark.alone\ndef test_second():\n    {second}\n"
    )
    assert whole(Path(sys.executable), args, [str(tmp_path)], os.environ) == status


def test_what_has_others_beside_it_uses_one_thread(tmp_path: Path) -> None:
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = alone: by itself\n")
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
    assert {name.partition("/")[0] for name in listed} == {"msg", "srv"}
    for name in listed:
        before = colcon._content(layout)
        with (package / name).open("a") as file:
            file.write("# changed\n")
        assert colcon._content(layout) != before, name
