"""The tutorial, command by command as a stranger would type it, and what its text promises."""

import json
import os
import re
import shlex
import subprocess

import pytest
from er_models.files import load_model

from test.conftest import ROOT
from test.graph_help import own_domain
from test.test_documentation import BLOCK

pytestmark = pytest.mark.slow
TEXT = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
COMMANDS = [
    line
    for block in BLOCK.findall(TEXT)
    for line in block.splitlines()
    if line.startswith("./er ")
]


def typed(folder, commands=COMMANDS, seconds=200):
    """Run the commands in order, in a folder beside the configuration."""
    for name in ("config", "docs"):
        (folder / name).symlink_to(ROOT / name)
    with own_domain() as own:
        env = {**os.environ, "ROS_DOMAIN_ID": own["ROS_DOMAIN_ID"]}
        for command in commands:
            done = subprocess.run(
                [str(ROOT / "er"), *shlex.split(command)[1:]], cwd=folder, capture_output=True, text=True,
                timeout=seconds, env=env,
            )  # fmt: skip
            assert done.returncode == 0, f"{command}\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
    return folder


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return typed(tmp_path_factory.mktemp("stranger"))


def result(place, name):
    return json.loads((place / name).read_text())


@pytest.mark.timeout(600)
def test_the_effects_are_found_one_after_the_other(place):
    first, last = result(place, "fitted.json"), result(place, "final.json")
    assert (first["effects"], last["effects"]) == (["coulomb_friction"], ["end_stop"])
    assert first["final_verdict"] == last["final_verdict"] == "adequate"
    truth = load_model(ROOT / "docs" / "tutorial" / "rig.yaml")
    found = load_model(place / "final.yaml")
    for effect, name in (("coulomb_friction", "F_c"), ("end_stop", "k_b"), ("end_stop", "x_b")):
        value, sd = found.value(effect, name), found.deviations[effect][name]
        assert abs(value - truth.value(effect, name)) < 4.0 * sd
        assert sd < 0.1 * value
    stop, sd = found.value("end_stop", "k_b"), found.deviations["end_stop"]["k_b"]
    assert 0.05 < sd / stop < 0.1, "5 to 10 %, as the text says"
    growth, sd = found.value("end_stop", "k_c"), found.deviations["end_stop"]["k_c"]
    assert growth < 3.0 * sd, "the data hardly tell it"


def test_the_plan_is_worth_what_it_says(place):
    assert result(place, "next.json")["verdict"] == "revealed"


def test_the_errors_are_those_of_the_table(place):
    said = [float(x) for x in re.findall(r"^\| .* \| ([\d.]+) N \|$", TEXT, re.M)]
    before, after = result(place, "before.json"), result(place, "after.json")
    by_record = after["rmse_by_record"]
    measured = [before["rmse"], by_record["fresh"], by_record["simulated"], after["noise_floor"]]
    assert measured == pytest.approx(said, rel=0.1)
    assert by_record["fresh"] < 1.1 * by_record["simulated"] < 0.5 * before["rmse"]


def test_the_pictures_are_those_of_the_report(place):
    shown = re.findall(r"\]\(tutorial/(\w+\.svg)\)", TEXT)
    assert len(shown) == 3
    for name in shown:
        assert (ROOT / "docs" / "tutorial" / name).is_file()
        assert (place / "improved" / "figures" / name).is_file()
