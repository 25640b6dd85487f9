"""docs/my_rig.md, command by command as a stranger types it; and folders that nobody has seen, all the same way."""

import json
import re
import runpy

import numpy as np
import pytest
from er_model_lab.cli.app import app
from er_models.files import load_model
from er_studies.bench.lab.page import PAGE, followed
from typer.testing import CliRunner

import er_model_lab as lab
from test.conftest import ROOT
from test.foreign import NOISE, make

TEXT = (ROOT / PAGE).read_text(encoding="utf-8")
DATA = ROOT / "docs" / "my_rig" / "messung"
MAKE = runpy.run_path(str(ROOT / "docs" / "my_rig" / "make.py"))

NAMES = {
    "t": "Zeit", "deflection": {"from": "Kolbenweg", "unit": "mm"},
    "duty": {"from": "Strom", "unit": "A", "full_scale": MAKE["TOP_CURRENT"]},
    "damper_force": {"from": "Kraft", "unit": "kN", "sign": -1},
}  # fmt: skip


@pytest.fixture(scope="module")
def followed_page(tmp_path_factory):
    """A folder in which the page was followed, and its last results."""
    folder = tmp_path_factory.mktemp("stranger")
    lines = list(followed(ROOT, folder))
    return folder, lines


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_page_ends_with_a_named_effect_its_pictures_and_files(followed_page):
    folder, lines = followed_page
    found = json.loads((folder / "found.json").read_text())
    assert found["effects"] == ["end_stop"]
    assert found["final_verdict"] == "adequate"
    values = load_model(folder / "better.yaml").effects
    assert values["coulomb_friction"]["F_c"] == pytest.approx(MAKE["FRICTION"], rel=0.2)
    assert values["guo_yield"]["f_c"] == pytest.approx(MAKE["YIELD"], rel=0.05)
    assert (folder / "found" / "index.html").stat().st_size > 1e5
    for name in re.findall(r"\]\(my_rig/(\w+\.svg)\)", TEXT):
        assert (DATA.parent / name).is_file()
        assert (folder / "found" / "figures" / name).is_file()
    assert (folder / "damper.fmu").stat().st_size > 1e4
    series = np.genfromtxt(folder / "series_fahrt_1.csv", delimiter=",", names=True)
    assert series.size == MAKE["RATE"] * MAKE["SECONDS"]
    assert sum(line.processor for line in lines) < 300.0


@pytest.mark.slow
def test_the_numbers_of_the_page_are_those_that_come_out(followed_page):
    found = json.loads((followed_page[0] / "found.json").read_text())
    said = re.search(r"from ([\d.]+) N to ([\d.]+) N", TEXT).groups()
    errors = [found[key]["held_out"] for key in ("rmse", "rmse_after")]
    assert [float(each) for each in said] == pytest.approx(errors, rel=0.02)


def test_the_data_of_the_page_are_made_by_the_script_beside_them(tmp_path):
    MAKE["main"](tmp_path)
    made, kept = (lab.load(p, names=NAMES).records for p in (tmp_path, DATA))
    assert [r.name for r in made] == [r.name for r in kept] == ["fahrt_1", "fahrt_2", "fahrt_3"]
    for one, other in zip(made, kept, strict=True):
        for channel, samples in one.channels.items():
            np.testing.assert_allclose(samples, other.channels[channel], rtol=1e-6, atol=1e-9)
    assert sum(path.stat().st_size for path in DATA.iterdir()) < 500e3


def run(*words):
    done = CliRunner().invoke(app, [str(w) for w in words])
    assert done.exit_code == 0, f"{words}\n{done.output[-2000:]}{done.exception!r}"
    return done.stdout


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.parametrize(("seed", "kind"), [(43, "er"), (256, "friction"), (32, "passive")])
def test_a_folder_that_nobody_has_seen_gives_away_what_is_hidden_in_it(seed, kind, tmp_path):
    made = make(tmp_path / "data", seed, kind)
    data, start, better = (tmp_path / name for name in ("data", "start.yaml", "better.yaml"))
    told = [word for c, column in made.said.items() for word in ("--set", f"{c}={column}")]
    run("map", data, *told)
    run("new", "theirs", "--from", data, "--out", start, "--kind", kind)
    run("improve", data, "--model", start, "--out", better, "--json", tmp_path / "found.json")
    found = json.loads((tmp_path / "found.json").read_text())
    assert made.hidden in found["effects"], (made, found["effects"], found["alternatives"])
    after, before = (found[key]["held_out"] for key in ("rmse_after", "rmse"))
    assert after < min(2.0 * NOISE * made.force, 0.6 * before)
    run("export", data, "--model", better, "--series", tmp_path / "series.csv")
    run("export", "--model", better, "--c", tmp_path / "c", "--lut", tmp_path / "lut.csv")
    assert {path.suffix for path in (tmp_path / "c").iterdir()} >= {".c", ".h"}
    assert len([*tmp_path.glob("series*.csv")]) == 2
