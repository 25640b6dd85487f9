"""A newcomer's walk as one test: README, site, tutorial, my rig, four corners under the real `ros2 launch`."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from er_studies.bench.lab.page import followed

from test import test_my_rig, test_site, test_tutorial
from test.conftest import ROOT
from test.test_launch_tools import four_corners, launching

pytestmark = [pytest.mark.slow, pytest.mark.alone]
README = (ROOT / "README.md").read_text(encoding="utf-8")
TWO = re.compile(r"^## Two commands\n.*?^```sh\n(.*?)^```", re.M | re.S)
LINK = re.compile(r"\]\(([^)#]+)[^)]*\)")
FIRST = "src/er_common/test/test_stamps.py"
"""One file of tests: what `./er test` does with all of them, test_suite tells."""


def place(folder: Path, name: str) -> Path:
    """A new folder of a step."""
    made = folder / name
    made.mkdir()
    return made


@pytest.mark.timeout(3600)
def test_a_newcomer_comes_from_the_readme_to_four_corners(tmp_path: Path) -> None:
    [block] = TWO.findall(README)
    demo, suite = (line.partition("#")[0].strip() for line in block.strip().splitlines())
    assert (demo, suite) == ("./er demo", "./er test")
    test_tutorial.typed(place(tmp_path, "two"), [demo, f"{suite} {ROOT / FIRST}"], 1200)

    site = test_site.made(place(tmp_path, "site"))
    for target in {each for each in LINK.findall(README) if "://" not in each}:
        assert (ROOT / target).exists(), target
        if target.endswith(".md"):
            assert (site / target).with_suffix(".html").is_file(), target

    tutorial = test_tutorial.typed(place(tmp_path, "tutorial"))
    test_tutorial.test_the_effects_are_found_one_after_the_other(tutorial)
    test_tutorial.test_the_errors_are_those_of_the_table(tutorial)

    rig = place(tmp_path, "rig")
    test_my_rig.test_the_page_ends_with_a_named_effect_its_pictures_and_files(
        (rig, list(followed(ROOT, rig)))
    )

    with launching(place(tmp_path, "launch")) as launch:
        four_corners(launch("er_bringup", "vehicle.launch.py", "duration:=1"))
