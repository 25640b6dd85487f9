"""A recording played to the cores: the same bit by bit, and what it always was unless a reason is given."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from contextlib import closing
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
import yaml

pytest.importorskip("rclpy")


from er_bringup.programs import CORES
from er_bringup.recording import opened
from er_records.readers.bag_names import custom_data
from rosbags.rosbag2 import StoragePlugin, Writer

from er_bringup import played
from er_bringup import replay as command
from er_common import topics
from test import replay_golden
from test.replay_golden import FILE, IN_THE_LOOP, TICKS


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return replay_golden.ride(tmp_path_factory.mktemp("ride") / "bag")


Replay = Callable[..., tuple[int, str, dict[str, Any]]]


@pytest.fixture
def replay(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Replay:
    """Runs the command; exit status, error line and JSON."""

    def run(bag: Path, *args: str) -> tuple[int, str, dict[str, Any]]:
        monkeypatch.setattr("sys.argv", ["replay", str(bag), *args, "--json", "-"])
        with pytest.raises(SystemExit) as ended:
            command.main()
        said = capsys.readouterr()
        return int(ended.value.code or 0), said.err, json.loads(said.out or "{}")

    return run


def test_the_command_finds_every_answer_the_same(
    replay: Replay, bag: Path, tmp_path: Path
) -> None:
    csv = [tmp_path / name for name in "ab"]
    for file in csv:
        status, words, result = replay(bag, "--values", str(file))
        assert status == 0, words
    found = {each["node"]: each for each in result["nodes"]}
    assert set(found) == set(IN_THE_LOOP)
    for name in IN_THE_LOOP:
        each = found[name]
        assert (each["same"], each["different"]) == (TICKS, 0), each
        assert each["only_bag"] == each["only_core"] == 0
    assert csv[0].read_bytes() == csv[1].read_bytes()
    assert csv[0].read_text().count("\n") == len(IN_THE_LOOP) * TICKS


def test_the_answers_are_golden(bag: Path) -> None:
    golden = yaml.safe_load(FILE.read_text())
    hint = "a change needs a reason: ./er exec python -m test.replay_golden --reason '...'"
    assert all(each["reason"].strip() for each in golden["reasons"])
    assert golden["reasons"][-1]["digest"] == replay_golden.digest(golden["values"]), hint
    found = replay_golden.answers(bag)
    assert set(found) == set(golden["values"])
    for name, each in found.items():
        assert len(each) == TICKS * len(CORES[name].said) // golden["every"]
        for before, after in zip(golden["values"][name], each, strict=True):
            wrong = {
                k: (before[k], after[k])
                for k in before
                if not replay_golden.same(before[k], after[k])
            }
            assert not wrong, f"{name}, seq {after['seq']}: {wrong}; {hint}"
            assert set(before) == set(after)


def changed(bag: Path, out: Path, change: Callable[[str, Any], Any]) -> Path:
    """A copy of a recording; change: topic and message to what is written, None for nothing."""
    from er_model_lab.nodes.selection import message_class
    from er_records.recording.bag_writer import BagWriter
    from rclpy.serialization import deserialize_message, serialize_message
    from rosbags.highlevel import AnyReader

    writer, made = BagWriter(out), {}
    with AnyReader([bag]) as reader:
        for c, when, raw in reader.messages():
            message = change(c.topic, deserialize_message(raw, message_class(c.msgtype)))
            if message is not None:
                made[c.topic] = made.get(c.topic) or writer.topic(c.topic, c.msgtype)
                writer.write(made[c.topic], when, serialize_message(message))
    custom = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    writer.close(custom["custom_data"])
    return out


def in_a_car(bag: Path, out: Path, space: str, names: dict[str, str]) -> Path:
    """A copy of a recording as one of a corner, some topics of which have other names."""
    from er_records.recording.bag_writer import BagWriter
    from rosbags.highlevel import AnyReader

    writer, made = BagWriter(out), {}
    with AnyReader([bag]) as reader:
        for c, when, raw in reader.messages():
            name = names.get(c.topic[1:], space + c.topic)
            made[name] = made.get(name) or writer.topic(name, c.msgtype)
            writer.write(made[name], when, raw)
    custom = custom_data(bag)
    for key in ("parameters", "models"):
        custom[key] = {space + node: each for node, each in custom[key].items()}
    custom["names"] = {f"{space}/{topic}": other for topic, other in names.items()}
    writer.close(custom)
    return out


def test_a_corner_with_topics_of_other_names_is_played_as_any(
    replay: Replay, bag: Path, tmp_path: Path
) -> None:
    names = {
        "sensors/acceleration": "/chassis/imu",
        "sensors/deflection": "/chassis/x",
        "pwm/applied": "/chassis/duty",
        "pwm/command": "/chassis/wanted",
    }
    car = in_a_car(bag, tmp_path / "car", "/car/left", names)
    status, words, _ = replay(car)
    assert status == 2
    assert "expected --namespace with one of /car/left, found none recorded in '/'" in words
    status, words, result = replay(car, "--namespace", "car/left")
    assert status == 0, words
    assert {each["node"] for each in result["nodes"]} == set(IN_THE_LOOP)
    assert all(each["same"] == TICKS for each in result["nodes"])


def test_the_last_bit_of_one_answer_is_noticed(replay: Replay, bag: Path, tmp_path: Path) -> None:
    import numpy as np

    def change(topic: str, message: Any) -> Any:
        if topic == "/force/unified" and message.seq == 333:
            message.force = float(np.nextafter(message.force, np.inf))
        return message

    status, _, result = replay(changed(bag, tmp_path / "c", change), "--node", "unified_observer")
    (each,) = result["nodes"]
    assert status == 1
    assert (each["same"], each["different"]) == (TICKS - 1, 1)
    assert each["first"].startswith("seq 333: force ")


def test_a_sample_the_node_never_had_is_left_out_when_asked(bag: Path, tmp_path: Path) -> None:
    """The node's own gap: what it said after it can only be repeated without that sample."""
    core = played.core_of(opened(bag), "skyhook_controller", "", {})
    lost = opened(bag)
    said = iter(played.play(lost, "skyhook_controller", core).answers)
    missing = {250, 251}

    def change(topic: str, message: Any) -> Any:
        gone = topic == "/sensors/acceleration" and message.seq in missing
        return None if gone else message

    other = opened(changed(bag, tmp_path / "lost", change))
    answers = iter(played.play(other, "skyhook_controller", core).answers)
    replaced = {m.seq: m for _, m in answers}
    assert missing.isdisjoint(replaced)

    def recorded(topic: str, message: Any) -> Any:
        return replaced.get(message.seq) if topic == "/pwm/command" else message

    with_gap = opened(changed(bag, tmp_path / "gap", recorded))
    follows = played.play(with_gap, "skyhook_controller", core, follow=True)
    assert (follows.same, follows.different, follows.only_core) == (TICKS - 2, 0, 0)
    plain = played.play(with_gap, "skyhook_controller", core)
    assert plain.only_core == 2
    assert next(said)[1].seq == 1


def test_silence_in_a_recording_is_silence_for_the_core(bag: Path, tmp_path: Path) -> None:
    def change(topic: str, message: Any) -> Any:
        return None if topic.startswith("/sensors/") and 300 <= message.seq < 400 else message

    silent = opened(changed(bag, tmp_path / "silent", change))
    # recorded in lockstep, where only the ages that the clock gives tell a silence
    core = played.core_of(silent, "skyhook_controller", "", {"max_age": 0.02})
    safe = [
        m
        for _, m in played.play(silent, "skyhook_controller", core).answers
        if m.source == m.SOURCE_SAFE
    ]
    # half a second without samples, told as safe again and again
    assert 5 <= len(safe) <= 25
    assert {m.seq for m in safe} == {299}


@pytest.fixture(scope="module")
def seeing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A gain file of the polytopic observer for both accelerometers and a deflection sensor."""
    from er_models.files import load_model
    from er_observers.gains import save_gains
    from er_observers.synthesis.make import Wish, synthesise

    car = load_model(replay_golden.VEHICLE)
    claim, certificate = synthesise("nlpv_polytopic", car, Wish(deflection=1e-3))
    path = tmp_path_factory.mktemp("gains") / "seeing.yaml"
    save_gains(path, "nlpv_polytopic", car, claim, certificate)
    return path


def seen(bag: Path, seeing: Path) -> list[Any]:
    """What the observer with a deflection sensor says to a recording."""
    name = "nlpv_polytopic_observer"
    recording = opened(bag)
    core = played.core_of(recording, name, "", {"gains_file": str(seeing)})
    return [m for _, m in played.play(recording, name, core).answers]


def test_an_observer_takes_the_deflection_sensor_its_gains_ask_for(
    bag: Path, seeing: Path
) -> None:
    """Played, it says bit for bit what its pure step says; the deflection of a tick comes after its accelerations."""
    from er_models.files import load_model
    from er_observers.running import runtime as observer
    from er_observers.running.ready import ready

    heard = (topics.ACCELERATION, topics.DEFLECTION, topics.PWM_APPLIED)
    ticks: dict[int, dict[str, Any]] = {}
    for topic, m, _ in opened(bag).messages({f"/{topic.name}": topic for topic in heard}):
        ticks.setdefault(m.seq, {})[topic.name] = m
    gains = ready(seeing, load_model(replay_golden.VEHICLE), "nlpv_polytopic")
    state, forces = None, []
    for seq, tick in sorted(ticks.items()):
        a, x, u = (tick[topic.name] for topic in heard)
        t = 1e-9 * ((seq - 1) * replay_golden.DT)
        sample = observer.Sample(t, a.sprung, a.unsprung, u.duty, x.deflection)
        state = (
            observer.start(gains, sample)
            if state is None
            else observer.step(gains, state, sample)[0]
        )
        forces.append(state.estimate.force)
    said = seen(bag, seeing)
    assert [m.seq for m in said] == sorted(ticks)
    assert [m.force for m in said] == forces
    assert all(m.status == m.STATUS_OK for m in said[20:])


def test_a_deflection_that_is_lost_holds_nothing_up_and_a_stuck_one_is_not_believed(
    bag: Path, seeing: Path, tmp_path: Path
) -> None:
    def lost(topic: str, message: Any) -> Any:
        return None if topic == "/sensors/deflection" and 300 <= message.seq < 306 else message

    def stuck(topic: str, message: Any) -> Any:
        if topic == "/sensors/deflection" and message.seq >= 300:
            message.deflection = 0.001
        return message

    whole = seen(bag, seeing)
    gap = seen(changed(bag, tmp_path / "gap", lost), seeing)
    assert [m.seq for m in gap] == [m.seq for m in whole]
    assert [m.force for m in gap[:298]] == [m.force for m in whole[:298]]
    assert {m.status for m in gap[299:305]} == {gap[0].STATUS_OK, gap[0].STATUS_DEGRADED}
    assert all(m.valid for m in gap[299:305])
    assert abs(gap[500].force - whole[500].force) < 1e-3
    held = seen(changed(bag, tmp_path / "stuck", stuck), seeing)
    assert all(m.valid for m in held[20:315])
    assert not any(m.valid for m in held[340:])


def test_another_parameter_gives_another_answer(replay: Replay, bag: Path) -> None:
    args = ("--node", "skyhook_controller", "--set", "u_max:=0.2")
    status, _, result = replay(bag, *args)
    assert status == 1
    assert "duty 0.3 recorded, 0.2 replayed" in result["nodes"][0]["first"]


@pytest.mark.parametrize(
    ("args", "status", "words"),
    [
        (("--node", "nix"), 2, "unknown node with a core 'nix'"),
        (("--set", "u_max"), 2, "--set: expected KEY:=VALUE"),
        (
            ("--set", "u_max:=[1"),
            2,
            r"--set u_max: expected a value as YAML writes it, found '\[1'",
        ),
        (("--set", "u_max:=08"), 2, "--set u_max: expected a value"),
        (("--values", "/dev/null/values.csv"), 2, "/dev/null/values.csv: expected a folder"),
        (("--set", "nix:=1"), 2, "--set: nix: expected a parameter of this node"),
        (
            ("--namespace", "fl"),
            2,
            "expected --namespace with one of /, found none recorded in '/fl'",
        ),
        (("--namespace", "fl", "--node", "skyhook_controller", "--set", "u_min:=0.0"), 2, "u_max"),
    ],
)
def test_bad_usage_is_one_line(
    replay: Replay, bag: Path, args: tuple[str, ...], status: int, words: str
) -> None:
    import re

    found, text, _ = replay(bag, *args)
    assert found == status
    assert re.search(words, text), text
    assert text.count("\n") == 1


def test_what_is_no_recording_is_refused_and_the_middle_of_one_is_said_to_be(
    replay: Replay, bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("run.csv", "run.mcap", "run.db3"):
        (tmp_path / name).write_text("t,x\n0,0\n")
        status, text, _ = replay(tmp_path / name)
        assert (status, text.count("\n")) == (2, 1), text

    assert replay(Path("/dev/null"))[0] == 2

    def later(topic: str, message: Any) -> Any:
        return message if getattr(message, "seq", TICKS) > TICKS // 2 else None

    from rich.console import Console

    late = opened(changed(bag, tmp_path / "late", later))
    known = opened(bag)
    late.parameters, late.models = known.parameters, known.models
    core = played.core_of(late, "unified_observer", "", {})
    found = played.play(late, "unified_observer", core)
    assert found.different > 0
    command.show(late, [found], Console())
    assert f"middle of the run (seq {TICKS // 2 + 1})" in " ".join(capsys.readouterr().out.split())


def test_a_sqlite_file_that_was_never_closed_is_damaged(tmp_path: Path) -> None:
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3):
        pass
    (tmp_path / "bag" / "metadata.yaml").unlink()
    file = tmp_path / "bag" / "bag.db3"
    with closing(sqlite3.connect(file)) as data:
        data.execute("DELETE FROM metadata")
        data.commit()
    assert "was never closed" in opened(file).damage


def test_a_recording_without_the_inputs_and_a_damaged_one(
    replay: Replay, bag: Path, tmp_path: Path
) -> None:
    def only_road(topic: str, message: Any) -> Any:
        return message if topic == "/sensors/road" else None

    status, text, _ = replay(changed(bag, tmp_path / "road", only_road))
    assert status == 4
    assert "/sensors/acceleration" in text
    cut = tmp_path / "cut"
    cut.mkdir()
    for file in bag.iterdir():
        data = file.read_bytes()
        if file.suffix == ".mcap":
            middle = len(data) // 2
            data = data[:middle] + bytes(2000) + data[middle + 2000 :]
        (cut / file.name).write_bytes(data)
    status, text, result = replay(cut, "--node", "unified_observer")
    assert status in (1, 2, 3)  # zeros in the middle are never "the same"
    assert "Traceback" not in text
    if status == 3:
        assert not result["complete"]
    for file in cut.glob("*.mcap"):
        file.write_bytes(file.read_bytes()[: file.stat().st_size * 6 // 10])
    status, text, _ = replay(cut)
    assert (status, text) == (3, "")


NEEDED = ("model_file", "gains_file")


@pytest.mark.parametrize("killed", [False, True])
def test_a_recording_that_was_cut_is_played_as_far_as_it_goes(
    replay: Replay, bag: Path, tmp_path: Path, *, killed: bool
) -> None:
    import shutil

    cut, node = tmp_path / "cut", "unified_observer"
    shutil.copytree(bag, cut)
    (file,) = cut.glob("*.mcap")
    file.write_bytes(file.read_bytes()[: file.stat().st_size * 6 // 10])
    given = replay_golden.node_parameters(node)
    args = [f"--set={name}:={given[name]}" for name in NEEDED] if killed else []
    if killed:
        (cut / "metadata.yaml").unlink()
        status, text, _ = replay(cut)
        assert status == 4
        assert (
            f"the parameters of {node} are not in the recording: give them, --node {node} "
            "--set model_file:=... --set gains_file:=..." in text
        )
        assert {line.split(": ")[0] for line in text.splitlines()} == {"er replay"}
    status, text, result = replay(cut, "--node", node, *args)
    assert status == 3, text
    assert (
        "at their defaults: leave_out, timeout, payload, deflection, max_age" in text
    ) == killed
    assert not result["complete"]
    assert ("metadata.yaml is missing" in result["damage"]) == killed
    (each,) = result["nodes"]
    assert each["same"] > TICKS // 2
    assert each["different"] == each["only_bag"] == 0


@pytest.fixture(scope="module")
def without(bag: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Copies of the recording without the topics that begin with a word."""

    def made(word: str) -> Path:
        out = tmp_path_factory.mktemp("without") / "bag"
        return changed(bag, out, lambda topic, m: None if topic.startswith(word) else m)

    return made


@pytest.mark.parametrize("gone", ["/sensors/acceleration", "/pwm/applied"])
def test_a_node_without_one_of_its_inputs_is_never_the_same(
    replay: Replay, without: Callable[[str], Path], gone: str
) -> None:
    status, text, result = replay(without(gone), "--node", "unified_observer")
    assert (status, text.count("\n")) == (4, 1), text
    assert f"channel '{gone}' is needed for unified_observer" in text
    assert not result["nodes"]


def test_nodes_that_can_be_compared_are_and_the_others_named(
    replay: Replay, without: Callable[[str], Path]
) -> None:
    part = without("/pwm/applied")
    status, text, result = replay(part)
    assert status == 0
    assert [each["node"] for each in result["nodes"]] == ["skyhook_controller"]
    assert set(result["left_out"]) == set(IN_THE_LOOP) - {"skyhook_controller"}
    assert text.count("\n") == len(IN_THE_LOOP) - 1
    asked = ("--node", "skyhook_controller", "--node", "unified_observer")
    status, _, result = replay(part, *asked)
    assert status == 4
    assert result["nodes"][0]["same"] == TICKS


def test_a_replay_without_recorded_answers_is_for_its_values_only(
    replay: Replay, without: Callable[[str], Path], tmp_path: Path
) -> None:
    args, file = (without("/force/"), "--node", "unified_observer"), tmp_path / "values.csv"
    status, text, _ = replay(*args)
    assert (status, text.count("\n")) == (4, 1)
    assert "unified_observer is compared with nothing: no answer of it is recorded" in text
    status, again, _ = replay(*args, "--values", str(file))
    assert (status, again) == (0, text)
    assert file.read_text().count("\n") == TICKS


def test_answers_to_other_samples_are_nothing_to_compare_with(
    replay: Replay, bag: Path, tmp_path: Path
) -> None:
    def apart(topic: str, message: Any) -> Any:
        return message if (message.seq < 9) == (topic == "/pwm/command") else None

    status, text, _ = replay(changed(bag, tmp_path / "b", apart), "--node", "skyhook_controller")
    assert status == 4
    assert "none of its 8 recorded answers is to a sample that the replay answers" in text


@pytest.mark.parametrize("hours", [1, 24 * 365 * 56])
def test_a_clock_that_was_set_forward_costs_some_steps_and_changes_no_answer(
    bag: Path, monkeypatch: pytest.MonkeyPatch, hours: int
) -> None:
    name, recording = "unified_observer", opened(bag)
    core, steps = played.core_of(recording, name, "", {}), 0
    on_time, messages = core.on_time, recording.messages

    def counted(state: Any, when: Any) -> Any:
        nonlocal steps
        steps += 1
        assert steps < 5000
        return on_time(state, when)

    def set_forward(names: Any) -> Any:
        for topic, message, arrival in messages(names):
            ahead = hours * 3600 * 10**9 if message.seq > TICKS // 2 else 0
            yield topic, message, arrival + ahead

    monkeypatch.setattr(core, "on_time", counted)
    monkeypatch.setattr(recording, "messages", set_forward)
    found = played.play(recording, name, core)
    assert (found.same, found.different) == (TICKS, 0)
    assert steps > 100  # a silence that is played
    assert found.span < 60.0
    assert found.skipped == pytest.approx(hours * 3600, abs=60.0)


@pytest.mark.parametrize(
    ("key", "noted"),
    [
        ("parameters", "[1]"),
        ("parameters", '{"/skyhook_controller": 5}'),
        ("names", "[1]"),
        ("names", '{"/sensors/force": [2]}'),
        ("models", "[]"),
        ("models", '{"/unified_observer": 5}'),
    ],
)
def test_notes_that_are_none_are_refused_in_one_line(
    replay: Replay, tmp_path: Path, key: str, noted: str
) -> None:
    from er_records.recording.bag_writer import BagWriter

    BagWriter(tmp_path / "bag").close({key: noted})
    status, text, _ = replay(tmp_path / "bag")
    assert (status, text.count("\n")) == (2, 1), text
    assert f"metadata.yaml: custom_data: {key}: expected an object with" in text
    assert text.endswith(f"found {noted}\n")


def test_what_a_recorder_that_was_held_up_wrote_is_played_as_the_node_had_it(
    replay: Replay, bag: Path, tmp_path: Path
) -> None:
    from er_records.recording.bag_writer import BagWriter
    from rosbags.highlevel import AnyReader

    held, written = (1_500_000_000, 1_800_000_000), []
    with AnyReader([bag]) as reader:
        for c, when, raw in reader.messages():
            # it found every topic's queue full, and emptied one after the other
            at = held[1] if held[0] < when < held[1] else when
            written.append((at, c.topic if at != when else "", c, bytes(raw)))
        writer, made = BagWriter(tmp_path / "held"), {}
        for at, _, c, raw in sorted(written, key=lambda each: each[:2]):
            made[c.topic] = made.get(c.topic) or writer.topic(c.topic, c.msgtype)
            writer.write(made[c.topic], at, raw)
    custom = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    writer.close(custom["custom_data"])
    status, text, result = replay(tmp_path / "held")
    assert status == 0, text
    for each in result["nodes"]:
        assert (each["same"], each["only_core"], each["only_bag"]) == (TICKS, 0, 0), each
        assert each["apart"] > 50
        assert each["by_tick"]


def test_each_of_two_answers_to_a_sample_is_compared(bag: Path) -> None:
    core = played.core_of(
        opened(bag), "model_monitor", "", replay_golden.node_parameters("model_monitor")
    )
    once = played.play(opened(bag), "model_monitor", core)
    assert len(once.answers) == 2 * TICKS
    recorded = played._first(once.answers)
    (topic, message), other = once.answers[-1], deepcopy(once.answers)
    changed_last = deepcopy(message)
    changed_last.force += 1e-9
    again = played.Played("model_monitor", answers=[*other[:-1], (topic, changed_last)])
    played._compare(again, recorded)
    assert (again.same, again.different, again.only_bag) == (2 * TICKS - 1, 1, 0)
