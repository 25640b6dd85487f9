"""Recordings: readable with the definitions inside, never over something else, soon on disk."""

import json
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy")

import yaml
from er_models.errors import ErError, InputError
from er_records.recording.bag_writer import BagWriter
from er_records.recording.message_definitions import full_definition
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader

from er_damper_msgs.msg import DamperForce

KIND = "er_damper_msgs/msg/DamperForce"


def write(bag: BagWriter, count: int, name: str = "/sensors/force") -> None:
    """That many messages with growing force."""
    topic = bag.topic(name, KIND)
    for k in range(count):
        message = DamperForce(seq=k + 1, force=0.5 * k, valid=True)
        bag.write(topic, 1_000_000_000 + 5_000_000 * k, serialize_message(message))


def information(out: Path) -> dict[str, Any]:
    """What metadata.yaml says."""
    text = yaml.safe_load((out / "metadata.yaml").read_text())
    return dict(text["rosbag2_bagfile_information"])


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_messages_come_back_typed_from_the_definitions_inside(
    tmp_path: Path, storage: str
) -> None:
    bag = BagWriter(tmp_path / "bag", storage)
    write(bag, 300)
    bag.close({"schema": "er_bag 1", "lost": {"/sensors/force": 0}})
    with AnyReader([tmp_path / "bag"]) as reader:
        found = [reader.deserialize(d, c.msgtype) for c, _, d in reader.messages()]
        definition = reader.connections[0].msgdef.data
    assert [m.force for m in found] == [0.5 * k for k in range(300)]
    assert "# [N] F_d, positive resists extension" in definition
    about = information(tmp_path / "bag")
    assert about["message_count"] == 300
    assert about["storage_identifier"] == storage
    assert json.loads(about["custom_data"]["lost"]) == {"/sensors/force": 0}


def test_the_hash_of_a_type_is_that_of_ros() -> None:
    index = pytest.importorskip("ament_index_python")
    folder = Path(index.get_package_share_directory("er_damper_msgs"))
    described = json.loads((folder / "msg/DamperForce.json").read_text())
    (wanted,) = [h["hash_string"] for h in described["type_hashes"] if h["type_name"] == KIND]
    assert full_definition(KIND)[1] == wanted


def test_a_type_nobody_knows_is_named() -> None:
    with pytest.raises(ErError, match="type nix_msgs/msg/Nix: package nix_msgs is not installed"):
        full_definition("nix_msgs/msg/Nix")


@pytest.mark.parametrize("kind", ["a folder", "a file"])
def test_nothing_is_overwritten(tmp_path: Path, kind: str) -> None:
    out = tmp_path / "bag"
    out.mkdir() if kind == "a folder" else out.write_text("precious")
    with pytest.raises(InputError, match=f"expected a path that does not exist yet, found {kind}"):
        BagWriter(out)
    assert out.is_dir() or out.read_text() == "precious"


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_what_was_flushed_is_on_disk(tmp_path: Path, storage: str) -> None:
    bag = BagWriter(tmp_path / "bag", storage)
    (file,) = [p for p in (tmp_path / "bag").iterdir() if p.suffix in (".mcap", ".db3")]
    before = file.stat().st_size
    write(bag, 300)
    bag.flush()
    assert file.stat().st_size > before + 300 * 60
    bag.flush()
    bag.close({})


def test_only_a_recording_of_nothing_can_be_discarded(tmp_path: Path) -> None:
    bag = BagWriter(tmp_path / "bag")
    write(bag, 1)
    with pytest.raises(ValueError, match="holds 1 messages"):
        bag.discard()
    bag.close({})
    worthless = BagWriter(tmp_path / "worthless")
    write(worthless, 2)
    with pytest.raises(ValueError, match="holds 2 messages"):
        worthless.discard(1)
    worthless.discard(2)
    assert not (tmp_path / "worthless").exists()
    empty = BagWriter(tmp_path / "empty")
    empty.discard()
    assert (tmp_path / "bag").exists()
    assert not (tmp_path / "empty").exists()


def test_a_full_disk_is_an_os_error_and_leaves_what_was_flushed(tmp_path: Path) -> None:
    bag = BagWriter(tmp_path / "bag", "sqlite3")
    write(bag, 300)
    bag.flush()
    storage: Any = bag._writer.storage
    storage.conn.execute("PRAGMA max_page_count = 1")
    with pytest.raises(OSError, match="database or disk is full") as refused:
        write(bag, 3000, "/more")
    assert refused.value.strerror == "database or disk is full"
    bag.close({})
    assert [p.name for p in (tmp_path / "bag").iterdir()] == ["bag.db3"]
    with AnyReader([tmp_path / "bag" / "bag.db3"]) as reader:
        assert sum(1 for _ in reader.messages()) == 300
