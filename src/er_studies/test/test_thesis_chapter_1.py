"""Chapter 1 made again: the simulated bench, the scores, and the whole command."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from er_model_lab.identification.law import response_time
from er_models.constants import SAMPLE_TIME as DT
from er_models.files import load_model
from er_models.model import Model
from er_models.program import Program, load_program, resolve
from er_models.simulation import simulate
from er_studies.thesis import chapter_1 as cases
from er_studies.thesis.chapter_1 import LAWS, PUBLISHED, ROADS, Case, Chapter1, case, chapter_1
from er_studies.thesis.chapter_1_text import columns, result, table_1_5
from er_studies.thesis.command import app
from er_studies.thesis.testbench import measure
from typer.testing import CliRunner

CONFIG = Path(__file__).resolve().parents[3] / "config"
NOISE = {
    "deflection": 2e-5,
    "deflection_velocity": 1e-3,
    "damper_force": 0.15,
    "sprung_acceleration": 0.025,
    "unsprung_acceleration": 0.025,
}
"""What the sensors of the testbench are taken for, SI."""


def vehicle() -> Model:
    return load_model(CONFIG / "vehicles" / "inove_stand_in.yaml")


def program(name: str) -> Program:
    return load_program(CONFIG / "experiments" / f"chapter_1_{name}.yaml")


def all_models(truth: Model, other: Model) -> dict[str, Model]:
    """One model under every name that a case asks for."""
    names = ["guo_added", *(f"{law}{end}" for law in LAWS for end in ("", "_staged", "_static"))]
    return {"truth": truth, **dict.fromkeys(names, other)}


def test_a_measurement_is_the_simulation_plus_the_noise_of_its_sensors() -> None:
    short = replace(program("bumps"), duration=4.0)
    record = measure(vehicle(), short, seed=3)
    exact = simulate(vehicle(), DT, *short.ride(DT))
    for name, deviation in NOISE.items():
        error = record.channels[name] - exact[name]
        assert np.std(error) == pytest.approx(deviation, rel=0.12)
        assert abs(np.mean(error)) < 0.2 * deviation
    assert np.array_equal(record.channels["road"], exact["road"])
    assert np.array_equal(record.channels["duty"], exact["duty"])
    again, other = (measure(vehicle(), short, seed) for seed in (3, 4))
    assert np.array_equal(again.channels["damper_force"], record.channels["damper_force"])
    assert not np.array_equal(other.channels["damper_force"], record.channels["damper_force"])


@pytest.mark.parametrize("name", ["linear", "yield", *ROADS])
def test_programs_stay_within_the_testbench(name: str) -> None:
    """Section 1.3: duty up to 0.3, velocity up to 0.15 m/s; and the damper moves at all."""
    resolved = resolve(program(name), vehicle(), DT)
    run = simulate(vehicle(), DT, *resolved.ride(DT))
    speed = np.abs(run["deflection_velocity"]).max()
    assert 0.08 < speed <= 0.15
    assert run["duty"].max() <= 0.3
    assert np.abs(run["deflection"]).max() < vehicle().rig["stroke"]


def test_programs_are_those_of_the_thesis() -> None:
    t = np.arange(0.0, 45.0, DT)
    duty = program("yield").signals(t)[1]
    assert np.unique(duty.round(9)).tolist() == [0.1, 0.15, 0.2, 0.25, 0.3]
    assert not program("linear").signals(t)[1].any()
    assert set(program("bumps").signals(t)[1]) == {0.2}
    assert program("iso").duty == {"kind": "constant", "level": 0.225}
    assert np.ptp(program("bumps").signals(t)[0]) == pytest.approx(0.010, rel=1e-3)


@pytest.fixture(scope="module")
def small() -> Case:
    """A short case: the damper itself, and the same with 1 N too much."""
    record = measure(vehicle(), replace(program("bumps"), duration=5.0), 0)
    truth = vehicle().without_effect("quarter_car")
    return case("bumps", record, all_models(truth, truth.with_effect("preload", {"F_0": 1.0})))


def test_errors_of_models_that_are_known(small: Case) -> None:
    """The damper itself leaves the noise (and what the noise of the motion makes); 1 N too much adds 1 N."""
    assert 0.14 < small.rmse("truth") < 0.24
    assert small.rmse("guo") == pytest.approx(np.hypot(1.0, small.rmse("truth")), rel=0.05)
    assert small.nrmse("guo") == pytest.approx(
        small.rmse("guo") / np.ptp(small.force[small.scored]), rel=1e-12
    )
    assert small.forces["guo"] - small.forces["truth"] == pytest.approx(1.0, abs=1e-9)
    assert small.rmse("guo_raw") > small.rmse("guo")


def test_turning_is_around_zero_velocity(small: Case) -> None:
    speed = np.abs(small.motion.v)
    assert 0 < small.turning.sum() < 0.3 * speed.size
    assert speed[small.turning].max() < speed[~small.turning].min()
    wrong = {**small.forces, "late": np.where(small.turning, small.force + 2.0, small.force)}
    late = replace(small, forces=wrong)
    assert late.rmse("late", late.turning) == pytest.approx(2.0)
    assert late.rmse("late", ~late.turning) == 0.0


def test_columns_line_up() -> None:
    assert columns(("a", "bb"), [("long", "1"), ("x", "22.5")]) == [
        "a       bb",
        "long     1",
        "x     22.5",
    ]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["chapter1", "--config", "nowhere"], "nowhere/vehicles/inove_stand_in.yaml"),
        (["chapter9"], "chapter9"),
    ],
)
def test_bad_usage_is_said_and_ends_with_2(words: list[str], said: str) -> None:
    found = CliRunner().invoke(app, words)
    assert found.exit_code == 2
    assert said in found.output
    assert "Traceback" not in found.output


@dataclass(frozen=True)
class Made:
    """What `./er study thesis chapter1 --report FOLDER` computed, printed and wrote."""

    chapter: Chapter1
    printed: str
    folder: Path
    data: dict[str, Any]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """The documented command, once; the chapter itself is taken along on its way."""
    folder, kept = tmp_path_factory.mktemp("chapter"), list[Chapter1]()

    def keeping(*given: Any) -> Chapter1:
        kept.append(chapter_1(*given))
        return kept[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cases, "chapter_1", keeping)
        words = ["chapter1", "--config", str(CONFIG), "--report", str(folder / "page")]
        found = CliRunner().invoke(app, [*words, "--json", str(folder / "chapter.json")])
    assert found.exit_code == 0, found.output
    data = json.loads((folder / "chapter.json").read_text(encoding="utf-8"))
    return Made(kept[0], found.output, folder / "page", data)


@pytest.mark.slow
def test_the_whole_chapter(made: Made) -> None:
    """What the thesis concludes, found again; and the page and JSON that show it."""
    chapter = made.chapter
    for name, found in chapter.validation.items():
        for law in LAWS:
            assert found.nrmse("truth") < found.nrmse(law) < 0.5 * PUBLISHED[name][law]
            assert found.nrmse(law) < 0.6 * found.nrmse(f"{law}_static")
    assert chapter.validation["bumps"].nrmse("guo") < chapter.validation["bumps"].nrmse("bingham")
    assert chapter.validation["iso"].nrmse("guo_added") < 0.7 * chapter.validation["iso"].nrmse(
        "guo"
    )
    tests = chapter.tests
    for law in LAWS:
        assert tests.rmse(law, tests.turning) < 0.6 * tests.rmse(f"{law}_static", tests.turning)
    table = chapter.identified["guo"].table
    assert table is not None
    true = response_time(chapter.truth, table.duty)
    assert np.abs(table.tau / true - 1.0).max() < 0.25
    assert len({row[0] for row in table_1_5(chapter)}) == 2
    data = made.data
    assert json.loads(json.dumps(result(chapter, 0), allow_nan=False)) == data
    ours = data["table_1_5"]["ISO road"]["guo"]["ours"]
    assert ours == pytest.approx(chapter.validation["iso"].nrmse("guo"))
    assert data["parameters"]["guo"]["guo_yield_by_direction"]["f_c_c"][2] == "N/duty"
    assert f"{ours:.4f}" in made.printed
    (page,) = made.folder.glob("*.html")
    assert f"{ours:.4f}" in page.read_text(encoding="utf-8")
    for figure in ("case_1", "case_2", "case_3", "case_4", "response_time"):
        assert (made.folder / "figures" / f"{figure}.png").stat().st_size > 10_000
        assert (made.folder / "figures" / f"{figure}.svg").is_file()
