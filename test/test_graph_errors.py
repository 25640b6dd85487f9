"""Wrong parameters, files and arguments: refused by every node in one line, with exit status 2."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from er_models.files import load_model, save_model

from test.graph_help import (
    GAINS,
    VEHICLE,
    Graph,
    main_of,
    observer_arguments,
    own_domain,
    plant_arguments,
    skyhook_arguments,
)


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[Graph]:
    with own_domain() as env, Graph(env, tmp_path) as made:
        yield made


Refused = Callable[..., str]


@pytest.fixture
def refused(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Iterator[Refused]:
    """Runs a main within this process; the one line with which it refuses its arguments."""

    def run(name: str, *args: str) -> str:
        monkeypatch.setattr(sys, "argv", [name, *args])
        with pytest.raises(SystemExit) as ended:
            main_of(name)()
        text = capfd.readouterr().err.strip()
        assert ended.value.code == 2, text
        assert len(text.splitlines()) == 1, text
        return text

    with own_domain() as env:
        for key in ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE"):
            monkeypatch.setenv(key, env[key])
        yield run


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("noise.force:=.nan", "noise.force: expected a number in 0..1000 [N], found nan"),
        ("noise.forse:=0.1", "did you mean noise.force?"),
        ("safe_duty:=high", "safe_duty: expected a number in 0..1"),
        ("safe_duty:=0.9", "safe_duty: expected a duty between duty_min and duty_max (0 to 0.3)"),
        ("road.amplitud:=0.1", "road.amplitud: expected a setting of a road or duty"),
        ("rate_factor:=2.0", "rate_factor: expected 1 in mode realtime, found 2"),
        ("model_file:=nix.yaml", "nix.yaml: expected a model file, found no file"),
        ("program_file:=nix.yaml", "nix.yaml: expected a program file, found no file"),
    ],
)
def test_the_plant_refuses(refused: Refused, given: str, words: str) -> None:
    assert words in refused("plant", *plant_arguments("-p", given))


def test_the_plant_refuses_a_damper_without_car(refused: Refused) -> None:
    damper = str(Path(VEHICLE).parents[1] / "dampers/inove_guo.yaml")
    line = refused("plant", *plant_arguments("-p", f"model_file:={damper}"))
    assert "a vehicle model with quarter_car" in line


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("u_max:=.nan", "u_max: expected a number in 0..1, found nan"),
        ("u_maxx:=0.3", "did you mean u_max?"),
        ("u_min:=0.4", "u_min, u_max: expected 0 <= u_min <= u_max <= 1"),
    ],
)
def test_the_controller_refuses(refused: Refused, given: str, words: str) -> None:
    assert words in refused("skyhook_controller", *skyhook_arguments("-p", given))


def test_the_controller_has_no_duty_of_its_own(refused: Refused) -> None:
    assert "u_min: expected" in refused("skyhook_controller")


def test_a_parameter_file_for_a_misspelt_node_is_not_ignored(
    refused: Refused, tmp_path: Path
) -> None:
    file = tmp_path / "other.yaml"
    file.write_text("/skyhok_controller:\n  ros__parameters:\n    u_min: 0.0\n")
    line = refused("skyhook_controller", *skyhook_arguments("--params-file", str(file)))
    assert "other.yaml: /skyhok_controller: expected parameters for /skyhook_controller" in line


def test_gains_for_another_model_are_refused(refused: Refused, tmp_path: Path) -> None:
    heavier = load_model(VEHICLE)
    values = {**heavier.effects["quarter_car"], "m_s": 1.2 * heavier.value("quarter_car", "m_s")}
    save_model(heavier.with_effect("quarter_car", values), tmp_path / "heavier.yaml")
    args = observer_arguments("-p", f"model_file:={tmp_path / 'heavier.yaml'}")
    line = refused("nlpv_polytopic_observer", *args)
    assert "nlpv_polytopic.yaml" in line
    assert "fingerprint" in line


def test_edited_gains_are_refused(refused: Refused, tmp_path: Path) -> None:
    text = Path(GAINS).read_text()
    edited = tmp_path / "gains.yaml"
    edited.write_text(text.replace("rate: 63.0", "rate: 64.0"))
    assert edited.read_text() != text
    args = observer_arguments("-p", f"gains_file:={edited}")
    assert "gains.yaml" in refused("nlpv_polytopic_observer", *args)


def test_the_recorder_overwrites_nothing(refused: Refused, tmp_path: Path) -> None:
    out = tmp_path / "bag"
    out.mkdir()
    (out / "precious").write_text("kept")
    line = refused("record", str(out))
    assert f"{out}: expected a path that does not exist yet, found a folder" in line
    assert [p.name for p in out.iterdir()] == ["precious"]


@pytest.mark.parametrize(
    "given",
    [
        ["--topics", "nothing_here", "--duration", "0.5"],
        ["--all", "--duration", "2.5"],
        ["--duration", "0.01"],
    ],
)
def test_a_recording_of_nothing_is_said_and_not_kept(
    graph: Graph, tmp_path: Path, given: list[str]
) -> None:
    out = tmp_path / "bag"
    status, text = graph.run("record", str(out), *given)
    assert status == 4
    assert ("nothing_here" if "--topics" in given else "to record anything") in text
    assert "Traceback" not in text
    assert not out.exists()


def test_what_others_say_on_a_shared_topic_is_a_recording(graph: Graph, tmp_path: Path) -> None:
    graph.start("skyhook_controller", *skyhook_arguments()).wait_for("[skyhook_controller]: ")
    out = tmp_path / "bag"
    status, text = graph.run("record", str(out), "--topics", "/diagnostics", "--duration", "4")
    assert status == 0, text
    assert (out / "metadata.yaml").exists()


def test_a_topic_that_cannot_be_is_named_before_a_folder_is_made(
    refused: Refused, tmp_path: Path
) -> None:
    out = tmp_path / "bag"
    assert "topic 'a-b': expected letters" in refused("record", str(out), "--topics", "a-b")
    assert not out.exists()


@pytest.mark.parametrize(
    ("program", "given", "words"),
    [
        ("record", ["--storage", "zip", "x"], "storage"),
        ("record", [], "OUT"),
        ("up", ["contrller:=none"], "did you mean controller?"),
        ("up", ["model:=nix"], "expected a file, or one of inove_quarter_car"),
        ("doctor", ["--secnds", "3"], "--secnds"),
        ("doctor", ["--seconds", "0"], "--seconds: expected 0.1 to 600"),
        ("doctor", ["--namespace", "a b"], "--namespace: expected names of letters"),
        ("inject", ["sensors/force", "off", "--namespace", "a//b"], "expected names of letters"),
        ("plant", ["--fast"], "unknown argument '--fast'"),
    ],
)
def test_bad_usage_is_one_line(
    refused: Refused, program: str, given: list[str], words: str
) -> None:
    assert words in refused(program, *given)


def test_up_ends_with_the_first_node_that_fails(graph: Graph, tmp_path: Path) -> None:
    parameters = tmp_path / "plant.yaml"
    parameters.write_text("/**:\n  ros__parameters:\n    safe_duty: 2.0\n")
    status, text = graph.run("up", f"plant_params:={parameters}", "observers:=none")
    assert status == 2
    assert "safe_duty: expected a number in 0..1, found 2.0" in text
    assert "er up: plant ended with exit status 2" in text
    assert "Traceback" not in text
