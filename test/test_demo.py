"""The demonstration: what it hides, how it judges itself, and the whole of it once, at the pace of the computer."""

from __future__ import annotations

import io
import json
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest
from er_bringup.demo import CLOSE, Verdict, judge
from er_bringup.demo_live import LATER
from er_bringup.hidden import RANGES, SPREAD, choose, hide
from er_models.errors import UnknownName
from er_models.files import load_model, save_model
from rich.console import Console

from er_bringup import demo as demo_module
from test.graph_help import CONFIG, ROOT, own_domain

DAMPER = CONFIG / "dampers/inove_guo.yaml"
FLOOR = 0.15


def test_every_seed_gives_one_effect_of_the_list() -> None:
    drawn = {choose("random", seed) for seed in range(200)}
    assert drawn == set(RANGES)
    assert choose("random", 5) == choose("random", 5)
    assert choose("none", 5) is None
    assert choose("preload", 5) == "preload"
    with pytest.raises(UnknownName, match="prelod"):
        choose("prelod", 5)


@pytest.mark.parametrize("effect", [*RANGES, None])
def test_what_is_hidden_is_within_its_range_in_a_damper_that_is_off(effect: str | None) -> None:
    given = load_model(DAMPER)
    hidden = hide(given, effect, 3)
    assert hide(given, effect, 3).digest() == hidden.digest() != hide(given, effect, 4).digest()
    assert set(hidden.effects) - set(given.effects) == ({effect} if effect else set())
    if effect:
        for name, (low, high) in RANGES[effect].items():
            assert low <= hidden.effects[effect][name] <= high
    for name, values in given.effects.items():
        for key, value in values.items():
            assert abs(hidden.effects[name][key] - value) <= SPREAD * abs(value)


def result(verdict: str, found: list[str], after: float, *ties: list[str]) -> dict[str, Any]:
    """What the lab answers, as far as it is judged."""
    return {
        "verdict": verdict, "effects": found, "alternatives": list(ties),
        "rmse": {"held_out": 0.5}, "rmse_after": {"held_out": after},
    }  # fmt: skip


@pytest.mark.parametrize(
    ("hidden", "answer", "success"),
    [
        ("preload", result("missing_effect", ["preload"], FLOOR), True),
        ("preload", result("missing_effect", ["preload"], 0.99 * CLOSE * FLOOR), True),
        ("preload", result("missing_effect", ["preload"], 1.01 * CLOSE * FLOOR), False),
        ("preload", result("missing_effect", ["gas_spring"], FLOOR), False),
        ("preload", result("missing_effect", ["preload", "dead_time"], FLOOR), False),
        ("preload", result("ambiguous", ["a"], FLOOR, ["a", "preload"]), True),
        ("preload", result("ambiguous", ["a"], FLOOR, ["a", "b", "preload"]), False),
        ("preload", result("adequate", [], FLOOR), False),
        (None, result("adequate", [], FLOOR), True),
        (None, result("missing_effect", ["preload"], FLOOR), False),
    ],
)
def test_success_is_the_right_name_and_the_floor(
    hidden: str | None, answer: dict[str, Any], success: bool
) -> None:
    assert judge(answer, hidden, FLOOR, 1.0).success is success


@pytest.mark.parametrize(("times", "failing", "status"), [(20, 1, 0), (20, 2, 1), (19, 1, 1)])
def test_of_many_one_in_twenty_may_fail(
    times: int, failing: int, status: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    left = iter([False] * failing + [True] * (times - failing))

    def play(*_: object) -> Verdict:
        return Verdict(
            "preload", ("preload",), "missing_effect", 0.5, FLOOR, FLOOR, next(left), 1.0
        )

    monkeypatch.setattr(demo_module, "play", play)
    told = Console(file=io.StringIO(), width=40)
    monkeypatch.setattr(demo_module, "console", lambda: told)
    words = ["er demo", "--repeat", str(times), "--seed", "1", "--out", str(tmp_path)]
    monkeypatch.setattr("sys.argv", words)
    with pytest.raises(SystemExit) as ended:
        demo_module.main()
    assert ended.value.code == status
    lines = told.file.getvalue().splitlines()
    assert lines[0].startswith("| seed | hidden | found |")
    cells = "preload | preload | missing_effect | 0.500 | 0.150 | 0.150"
    assert lines[2:4] == [
        f"| 1 | {cells} | NO |",
        f"| 11 | {cells} | {'yes' if failing == 1 else 'NO'} |",
    ]
    assert len(lines) == 2 + times + 1


def test_a_place_that_cannot_be_written_to_is_one_line(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setattr("sys.argv", ["er demo", "--seed", "1", "--out", str(tmp_path / "file/x")])
    with pytest.raises(SystemExit) as ended:
        demo_module.main()
    assert ended.value.code == 2
    assert capsys.readouterr().err == f"er demo: {tmp_path}/file/x: Not a directory\n"


def test_the_demonstration_finds_what_it_hid(tmp_path: Path) -> None:
    words = ["--mode", "lockstep", "--effect", "coulomb_friction", "--seed", "1"]
    with own_domain() as env:
        done = subprocess.run(
            [ROOT / "er", "demo", *words, "--learn", "12", "--check", "4", "--out", tmp_path / "demo"],
            env=os.environ | env, capture_output=True, text=True, timeout=240, check=False,
        )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "hidden: coulomb_friction" in done.stdout
    assert "success" in done.stdout
    assert "bit for bit as recorded" in done.stdout
    said = json.loads((tmp_path / "demo/result.json").read_text(encoding="utf-8"))
    assert said["effects"] == ["coulomb_friction"]
    assert (tmp_path / "demo/report/index.html").is_file()
    assert load_model(tmp_path / "demo/model.yaml").effects.keys() >= {"coulomb_friction"}


@pytest.mark.parametrize("later", LATER)
def test_what_begins_later_is_within_its_bounds(later: str, tmp_path: Path) -> None:
    """In every damper that is hidden at first: a plant takes the file."""
    for effect in RANGES:
        truth = hide(load_model(DAMPER), effect, 3).with_effect(*LATER[later])
        save_model(truth, tmp_path / "damper.yaml")
        assert load_model(tmp_path / "damper.yaml").effects.keys() >= {effect, LATER[later][0]}


@pytest.mark.slow
@pytest.mark.alone
@pytest.mark.timeout(1500)
@pytest.mark.parametrize("later", LATER)
def test_the_live_demonstration_finds_what_is_hidden_and_that_something_began(later: str) -> None:
    """Its own judgement counts: the name of what is hidden, an alarm in time, and twice a fall of the live error."""
    words = ["--live", "--no-browser", "--effect", "coulomb_friction", "--seed", "1"]
    with own_domain() as env:
        alone = {k: v for k, v in env.items() if not k.startswith(("PYTEST", "NICEGUI"))}
        done = subprocess.run(
            [str(ROOT / "er"), "demo", *words, "--later", later],
            cwd=ROOT, env=alone, capture_output=True, text=True, timeout=1400, check=False,
        )  # fmt: skip
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    assert "alarm after" in said
