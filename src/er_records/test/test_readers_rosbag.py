"""rosbag2: alignment by stamp, namespaces, validity, and every way a recording can be damaged."""

from __future__ import annotations

import json
import shutil
import sqlite3
import struct
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from er_models.errors import InputError, MissingChannel
from er_records.load import load
from er_records.record import Record
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

DEFINITIONS = Path(__file__).parents[2] / "er_damper_msgs" / "msg"
TICK = 5_000_000
START = 1_700_000_000_123_456_789
N = 1200
TOPICS = {
    "sensors/deflection": "SuspensionDeflection",
    "sensors/acceleration": "SuspensionAcceleration",
    "sensors/force": "DamperForce",
    "sensors/road": "RoadDisplacement",
    "pwm/applied": "PwmDuty",
    "pwm/command": "PwmDuty",
    "force/unified": "DamperForce",
}


def typestore() -> Typestore:
    """ROS 2 Jazzy's messages and those of this project."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for file in DEFINITIONS.glob("*.msg"):
        store.register(get_types_from_msg(file.read_text(), f"er_damper_msgs/msg/{file.stem}"))
    return store


STORE = typestore()


def force_at(k: int) -> float:
    """The force of tick k: tells the tick [N]."""
    return 0.25 * k


def content(topic: str, k: int) -> dict[str, Any]:
    """Fields of the message of tick k."""
    x = 5e-3 * np.sin(2 * np.pi * 0.005 * k)
    return {
        "sensors/deflection": {"deflection": x, "velocity": 2.0 * x, "velocity_valid": True},
        "sensors/acceleration": {"sprung": x + 1.0, "unsprung": x + 2.0},
        "sensors/force": {"force": force_at(k)},
        "sensors/road": {"displacement": 1e-3 * x},
        "pwm/applied": {"duty": 0.1 * (k // 100 % 4)},
        "pwm/command": {"duty": 0.9},
        "force/unified": {"force": force_at(k) + 1.0},
    }[topic]


@dataclass
class Sent:
    """A message to record: tick, stamp and changes to its fields."""

    topic: str
    k: int
    stamp: int
    changes: dict[str, Any] = field(default_factory=dict)


def ticks(n: int = N, topics: dict[str, str] = TOPICS) -> Iterator[Sent]:
    """All messages of n ticks."""
    for k in range(n):
        for topic in topics:
            yield Sent(topic, k, START + k * TICK)


def build(topic: str, sent: Sent) -> bytes:
    """The serialized message."""
    kind = f"er_damper_msgs/msg/{TOPICS[topic]}"
    cls = STORE.types[kind]
    stamp = STORE.types["builtin_interfaces/msg/Time"](*divmod(sent.stamp, 10**9))
    header = STORE.types["std_msgs/msg/Header"](stamp, "")
    fields: dict[str, Any] = {}
    for name, (node, args) in STORE.fielddefs[kind][1]:
        fields[name] = {"header": header, "valid": True, "seq": sent.k + 1}.get(name, 0)
        if int(node) == 1 and args[0] == "bool" and name != "valid":
            fields[name] = False
    fields |= content(topic, sent.k) | sent.changes
    return bytes(STORE.serialize_cdr(cls(**fields), kind))


def record_bag(
    path: Path,
    messages: Iterator[Sent] | list[Sent],
    storage: StoragePlugin = StoragePlugin.MCAP,
    namespaces: tuple[str, ...] = ("",),
    compression: CompressionMode = CompressionMode.NONE,
    names: dict[str, str] | None = None,
    noted: bool = False,
) -> Path:
    """Write a rosbag2 folder; messages arrive in the order given, whatever their stamps.

    names: of topics that have others, {} in them is the namespace; noted: as our recorder does.
    """
    others = names or {}
    writer = Writer(path, version=9, storage_plugin=storage)
    if compression != CompressionMode.NONE:
        writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        links = {
            (ns, topic): writer.add_connection(
                others.get(topic, "{}/" + topic).format(ns),
                f"er_damper_msgs/msg/{kind}",
                typestore=STORE,
            )
            for ns in namespaces
            for topic, kind in TOPICS.items()
        }
        for i, sent in enumerate(messages):
            data = build(sent.topic, sent)
            for ns in namespaces:
                writer.write(links[ns, sent.topic], START + 10**9 + 700_000 * i, data)
        if noted:
            each = {
                f"{ns}/{t}": other.format(ns) for ns in namespaces for t, other in others.items()
            }
            writer.set_custom_data("names", json.dumps(each))
    return path


def one(path: Path) -> Record:
    """The only record of a recording."""
    (record,) = load([path])
    return record


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A whole recording in MCAP."""
    return record_bag(tmp_path_factory.mktemp("bags") / "whole", ticks())


def check_values(record: Record, first: int = 0) -> None:
    """Every channel of tick k stands in the row of tick k."""
    k = first + np.arange(len(record))
    for topic, names in {
        "sensors/deflection": {"deflection": "deflection", "velocity": "deflection_velocity"},
        "sensors/acceleration": {
            "sprung": "sprung_acceleration",
            "unsprung": "unsprung_acceleration",
        },
        "sensors/force": {"force": "damper_force"},
        "sensors/road": {"displacement": "road"},
        "pwm/applied": {"duty": "duty"},
        "force/unified": {"force": "force_unified"},
    }.items():
        for own, channel in names.items():
            expected = np.asarray([content(topic, int(i))[own] for i in k])
            samples = record.channels[channel]
            # estimates may lack samples where the recording was damaged, measurements may not
            there = (
                ~np.isnan(samples) if channel == "force_unified" else np.ones(k.size, dtype=bool)
            )
            np.testing.assert_allclose(samples[there], expected[there], rtol=1e-12)
            assert there.mean() > 0.99


@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_a_whole_recording_is_read_without_loss(tmp_path: Path, storage: StoragePlugin) -> None:
    path = record_bag(tmp_path / "bag", ticks(), storage)
    record = one(path)
    assert record.complete
    assert record.name == "bag"
    assert len(record) == N
    np.testing.assert_allclose(record.t, 0.005 * np.arange(N), atol=1e-9)
    check_values(record)
    assert "t = 0 is the stamp 1700000000.123456789 s" in record.notes
    single = next(path.glob("*.mcap" if storage == StoragePlugin.MCAP else "*.db3"))
    assert single.parent == path
    alone = one(single)
    np.testing.assert_array_equal(alone.channels["duty"], record.channels["duty"])
    assert alone.digest == record.digest


def test_message_compression_is_understood(tmp_path: Path) -> None:
    path = record_bag(tmp_path / "bag", ticks(500), compression=CompressionMode.MESSAGE)
    check_values(one(path))


def test_each_namespace_is_a_record(tmp_path: Path) -> None:
    path = record_bag(tmp_path / "bag", ticks(500), namespaces=("/car/front_left", "/car/rear"))
    records = load([path])
    assert [r.name for r in records] == ["bag/car/front_left", "bag/car/rear"]
    for record in records:
        check_values(record)


OWN = {"sensors/deflection": "/chassis{}/x", "sensors/acceleration": "/chassis{}/imu"}
DUTIES = {"pwm/applied": "/chassis{}/duty", "pwm/command": "/chassis{}/wanted"}


def test_topics_of_other_names_are_found_where_the_recorder_noted_them(tmp_path: Path) -> None:
    corners = ("/car/left", "/car/right")
    whole = record_bag(
        tmp_path / "car", ticks(600), namespaces=corners, names=OWN | DUTIES, noted=True
    )
    records = load([whole])
    assert [record.name for record in records] == ["car/car/left", "car/car/right"]
    for record in records:
        check_values(record)
        assert not any("is read as" in note for note in record.notes)


def test_topics_of_other_names_are_found_by_their_types_where_these_tell(tmp_path: Path) -> None:
    record = one(record_bag(tmp_path / "one", ticks(600), namespaces=("/left",), names=OWN))
    check_values(record)
    assert (
        "/chassis/left/x is read as sensors/deflection: the only one of type "
        "er_damper_msgs/msg/SuspensionDeflection"
    ) in record.notes
    # a duty may be that asked for or that applied: only the name tells
    record = one(record_bag(tmp_path / "two", ticks(600), names=OWN | DUTIES))
    assert "deflection" in record.channels
    assert "duty" not in record.channels


def test_topics_of_other_names_are_named_where_nothing_tells_them_apart(tmp_path: Path) -> None:
    topics = {t: "/chassis{}/" + t.replace("/", "_") for t in TOPICS}
    car = record_bag(tmp_path / "car", ticks(3), namespaces=("/a", "/b"), names=topics)
    words = r"of its kind are /chassis/a/sensors_acceleration, /chassis/a/sensors_deflection, /ch"
    with pytest.raises(MissingChannel, match=words) as caught:
        load([car])
    assert "\n" not in str(caught.value)


def test_arrival_order_does_not_matter(tmp_path: Path) -> None:
    messages = list(ticks(600))
    swapped = [m for i in range(0, len(messages), 30) for m in reversed(messages[i : i + 30])]
    record = one(record_bag(tmp_path / "bag", swapped))
    check_values(record)
    assert any("out of order, sorted by stamp" in note for note in record.notes)
    assert record.complete


def test_repeated_stamps_are_dropped(tmp_path: Path) -> None:
    messages = [m for m in ticks(600) for _ in range(2 if m.k == 300 else 1)]
    record = one(record_bag(tmp_path / "bag", messages))
    check_values(record)
    assert any("1 message with a repeated stamp" in note for note in record.notes)


def test_lost_ticks_are_bridged_and_long_silence_splits(tmp_path: Path) -> None:
    few = [m for m in ticks() if not (m.topic == "sensors/force" and 400 <= m.k < 404)]
    record = one(record_bag(tmp_path / "few", few))
    assert record.complete
    assert any("damper_force: 4 missing samples bridged" in note for note in record.notes)
    check_values(record)
    many = [m for m in ticks() if not (m.topic == "sensors/force" and 600 <= m.k < 640)]
    pieces = load([record_bag(tmp_path / "many", many)])
    assert [p.name for p in pieces] == ["many#1", "many#2"]
    assert not any(p.complete for p in pieces)
    check_values(pieces[1], first=640)


def test_invalid_messages_are_gaps_not_zeros(tmp_path: Path) -> None:
    def broken(m: Sent) -> Sent:
        if m.topic == "sensors/force" and 500 <= m.k < 503:
            m.changes = {"force": 0.0, "valid": False}
        if m.topic == "force/unified" and m.k < 50:
            m.changes = {"force": 0.0, "valid": False}
        if m.topic == "sensors/deflection":
            m.changes = {"velocity": 0.0, "velocity_valid": False}
        return m

    record = one(record_bag(tmp_path / "bag", [broken(m) for m in ticks()]))
    assert len(record) == N
    assert record.complete
    np.testing.assert_allclose(record.channels["damper_force"], 0.25 * np.arange(N))
    assert np.isnan(record.channels["force_unified"][:50]).all()
    assert record.channels["force_unified"][50] == force_at(50) + 1.0
    assert record.derived == ("deflection_velocity",)


def test_duty_holds_from_its_stamp_on(tmp_path: Path) -> None:
    messages = [m for m in ticks() if m.topic != "pwm/applied" or m.k % 4 == 1]
    record = one(record_bag(tmp_path / "bag", messages))
    k = 1 + np.arange(len(record))
    in_force = 1 + 4 * ((k - 1) // 4)
    np.testing.assert_array_equal(record.channels["duty"], 0.1 * (in_force // 100 % 4))
    assert any("cut at the ends" in note for note in record.notes)


def test_a_sensor_with_a_rate_of_its_own_is_interpolated_and_said_so(tmp_path: Path) -> None:
    def own_rate(m: Sent) -> list[Sent]:
        if m.topic != "sensors/force":
            return [m]
        return [Sent(m.topic, m.k, m.stamp + 1_300_000)] if m.k % 2 == 0 else []

    record = one(record_bag(tmp_path / "bag", [s for m in ticks() for s in own_rate(m)]))
    assert any("sensors/force (100 Hz) carries other stamps" in note for note in record.notes)
    expected = 0.25 * (1 + np.arange(len(record)) - 0.26)
    np.testing.assert_allclose(record.channels["damper_force"], expected, atol=1e-6)


def test_a_clock_offset_is_named_and_the_channel_dropped(tmp_path: Path) -> None:
    def other_clock(m: Sent) -> Sent:
        return Sent(m.topic, m.k, m.stamp + 10**11) if m.topic == "sensors/force" else m

    record = one(record_bag(tmp_path / "bag", [other_clock(m) for m in ticks()]))
    assert not record.complete
    assert not record.has("damper_force")
    assert any("sensors/force covers 0 s" in n and "+100 s" in n for n in record.notes)


def test_after_a_restart_of_time_only_the_first_pass_counts(tmp_path: Path) -> None:
    record = one(record_bag(tmp_path / "bag", [*ticks(700), *ticks(300)]))
    assert len(record) == 700
    check_values(record)
    assert any("time jumps back after 700 messages" in note for note in record.notes)


def test_stray_messages_without_a_proper_stamp_are_dropped(tmp_path: Path) -> None:
    def stray(m: Sent, ticks: tuple[int, ...], stamp: int) -> Sent:
        hit = m.topic == "sensors/force" and m.k in ticks
        return Sent(m.topic, m.k, stamp if hit else m.stamp)

    zero = [stray(m, (300, 301), 0) for m in ticks(700)]
    record = one(record_bag(tmp_path / "zero", zero))
    check_values(record)
    assert "/sensors/force: 2 messages without a stamp dropped" in record.notes
    old = [stray(m, (350,), START - 10**10) for m in ticks(700)]
    record = one(record_bag(tmp_path / "old", old))
    check_values(record)
    assert any("1 message with a stamp far in the past" in note for note in record.notes)


SECOND = 10**9


@pytest.mark.parametrize(
    ("strays", "words"),
    [
        ({200: 100}, "1 message with a stamp far in the future"),
        ({0: 100}, "1 message with a stamp far in the future"),
        ({200: 100, 201: 7}, "2 messages with a stamp far in the future"),
        ({k: 300 - k for k in range(200, 204)}, "4 messages with a stamp far in the future"),
        ({k: 100 for k in range(3, 700, 9)}, "78 messages with a stamp far in the future"),
        ({200: 100, 201: -100}, "1 message with a stamp far in the past"),
        ({200: -100, 201: 100}, "1 message with a stamp far in the future"),
    ],
)
def test_stray_messages_ahead_of_time_cost_nothing_behind_them(
    tmp_path: Path, strays: dict[int, int], words: str
) -> None:
    sent = [
        Sent(m.topic, m.k, m.stamp + SECOND * strays.get(m.k, 0))
        if m.topic == "sensors/force"
        else m
        for m in ticks(700)
    ]
    record = one(record_bag(tmp_path / "bag", sent))
    assert len(record) >= 699
    check_values(record, first=700 - len(record))
    assert f"/sensors/force: {words} dropped" in record.notes
    assert not any("time jumps back" in note for note in record.notes)


@pytest.mark.parametrize("back", [0.6, 0.7, 2.0, 1e3])
def test_a_clock_that_is_set_back_is_no_stray(tmp_path: Path, back: float) -> None:
    sent = [Sent(m.topic, m.k, m.stamp - int(back * SECOND) * (m.k >= 500)) for m in ticks(800)]
    record = one(record_bag(tmp_path / "bag", sent))
    assert len(record) == 500
    check_values(record)
    assert "/sensors/force: time jumps back after 500 messages; 300 behind it left out" in (
        record.notes
    )
    assert not any("future" in note for note in record.notes)


@pytest.mark.parametrize("compression", [CompressionMode.NONE, CompressionMode.STORAGE])
@pytest.mark.parametrize("ending", ["metadata.yaml there", "recorder killed"])
def test_a_truncated_mcap_is_salvaged_with_a_count(
    tmp_path: Path, compression: CompressionMode, ending: str
) -> None:
    n = 3000
    path = record_bag(tmp_path / "bag", ticks(n), compression=compression)
    file = next(path.glob("*.mcap"))
    data = file.read_bytes()
    file.write_bytes(data[: int(0.6 * len(data))])
    if ending == "recorder killed":
        (path / "metadata.yaml").unlink()
    record = one(path)
    assert not record.complete
    assert len(record) >= 0.57 * n
    check_values(record)
    (note,) = [note for note in record.notes if "messages salvaged" in note]
    assert "bag.mcap is damaged" in note
    if ending != "recorder killed":
        assert f"of {n * 6} messages" in note


def chunks(data: bytes) -> list[tuple[int, int]]:
    """Offset and length of the content of each chunk of an MCAP file."""
    found, at = [], 8
    while at + 9 < len(data):
        opcode, length = struct.unpack_from("<BQ", data, at)
        if opcode == 0x06:
            found.append((at + 9, length))
        at += 9 + length
    return found


@pytest.mark.parametrize("compression", [CompressionMode.NONE, CompressionMode.STORAGE])
def test_a_zeroed_block_inside_an_mcap_costs_only_its_chunk(
    tmp_path: Path, compression: CompressionMode
) -> None:
    n = 6000
    path = record_bag(tmp_path / "bag", ticks(n), compression=compression)
    file = next(path.glob("*.mcap"))
    data = bytearray(file.read_bytes())
    places = chunks(bytes(data))
    assert len(places) > 3
    start, length = places[1]
    data[start + length // 2 : start + length // 2 + 2000] = bytes(2000)
    file.write_bytes(data)
    pieces = load([path])
    assert not any(piece.complete for piece in pieces)
    assert any("salvaged" in note for note in pieces[0].notes)
    assert sum(len(piece) for piece in pieces) > n * (1.0 - 1.2 / len(places))
    assert [piece.name for piece in pieces] == ["bag#1", "bag#2"]
    assert round(pieces[-1].t[-1] / 0.005) == n - 1
    for piece in pieces:
        check_values(piece, first=round(piece.t[0] / 0.005))


def test_messages_that_vanish_without_an_error_are_missed(tmp_path: Path) -> None:
    path = record_bag(tmp_path / "bag", ticks(3000))
    file = next(path.glob("*.mcap"))
    data = bytearray(file.read_bytes())
    start, length = chunks(bytes(data))[1]
    at, end = start + 40, start + length
    # zeros read as empty records of 9 bytes: an erased tail that ends evenly raises no error
    while (end - at) % 9 or at < start + length * 3 // 4:
        at += 9 + struct.unpack_from("<Q", data, at + 1)[0]
    data[at:end] = bytes(end - at)
    file.write_bytes(data)
    pieces = load([path])
    assert not pieces[0].complete
    assert any("messages are readable" in note for note in pieces[0].notes)


def test_a_cut_sqlite_bag_is_named_and_gives_what_it_can(tmp_path: Path) -> None:
    path = record_bag(tmp_path / "bag", ticks(2000), StoragePlugin.SQLITE3)
    file = next(path.glob("*.db3"))
    data = file.read_bytes()
    file.write_bytes(data[:-100])
    (path / "metadata.yaml").unlink()
    record = one(path)
    assert not record.complete
    assert len(record) > 1500
    assert any("bag.db3 is damaged" in note and "messages read" in note for note in record.notes)
    file.write_bytes(data[:3000])
    with pytest.raises(InputError, match=r"bag.db3 is damaged \(.+\): 0 messages read") as caught:
        load([path])
    assert "\n" not in str(caught.value)


def test_a_sqlite_bag_that_was_never_closed_is_incomplete(tmp_path: Path) -> None:
    path = record_bag(tmp_path / "bag", ticks(600), StoragePlugin.SQLITE3)
    (path / "metadata.yaml").unlink()
    assert one(path).complete
    journal = path / "bag.db3-journal"
    journal.write_bytes(b"")
    assert one(path).complete
    journal.write_bytes(b"pages")
    assert not one(path).complete
    journal.unlink()
    file = path / "bag.db3"
    for change in (
        "UPDATE metadata SET metadata = 'message_count: 0'",
        "DELETE FROM metadata",
    ):
        with closing(sqlite3.connect(file)) as data:
            data.execute(change)
            data.commit()
        for each in (path, file):
            record = one(each)
            assert not record.complete
            assert "bag.db3 was never closed: it has no record of its end" in record.notes
            check_values(record)
    with closing(sqlite3.connect(file)) as data:
        data.execute("DROP TABLE metadata")
        data.commit()
    assert one(path).complete


@pytest.mark.parametrize("suffix", [".mcap", ".db3"])
@pytest.mark.parametrize("data", [b"", b"not a recording at all " * 50])
def test_a_file_that_is_no_recording_is_named(tmp_path: Path, suffix: str, data: bytes) -> None:
    file = tmp_path / f"run{suffix}"
    file.write_bytes(data)
    for path in (file, tmp_path):
        with pytest.raises(InputError) as caught:
            load([path])
        assert file.name in str(caught.value)
        assert "\n" not in str(caught.value)


def test_a_missing_or_broken_metadata_file_does_not_stop_the_reading(
    tmp_path: Path, whole: Path
) -> None:
    path = tmp_path / "whole"
    shutil.copytree(whole, path)
    (path / "metadata.yaml").write_text("rosbag2_bagfile_information: [oops\n")
    record = one(path)
    check_values(record)
    assert any("cannot be read as a whole" in note for note in record.notes)
    (path / "metadata.yaml").unlink()
    record = one(path)
    assert record.complete
    check_values(record)
    assert any("metadata.yaml is missing" in note for note in record.notes)


def test_a_recording_that_lost_a_file_is_incomplete(tmp_path: Path, whole: Path) -> None:
    path = tmp_path / "whole"
    shutil.copytree(whole, path)
    text = (path / "metadata.yaml").read_text()
    more = text.replace("relative_file_paths:\n", "relative_file_paths:\n  - whole_9.mcap\n", 1)
    assert more != text
    (path / "metadata.yaml").write_text(more)
    record = one(path)
    assert not record.complete
    assert "whole_9.mcap is listed in metadata.yaml but missing" in record.notes
    for file in path.glob("*.mcap"):
        file.unlink()
    with pytest.raises(InputError, match=r"\.mcap or \.db3"):
        load([path])


def test_other_topics_and_other_messages_are_named(tmp_path: Path) -> None:
    def write(path: Path, topic: str, kind: str) -> Path:
        with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            link = writer.add_connection(topic, kind, typestore=STORE)
            message = STORE.types[kind](1.5)
            writer.write(link, START, STORE.serialize_cdr(message, kind))
        return path

    with pytest.raises(
        MissingChannel, match=r"a: .*sensors/deflection.*present: /chatter"
    ) as caught:
        load([write(tmp_path / "a", "/chatter", "std_msgs/msg/Float64")])
    assert caught.value.exit_status == 4
    with pytest.raises(InputError, match=r"topic /sensors/force: .*std_msgs/msg/Float64"):
        load([write(tmp_path / "b", "/sensors/force", "std_msgs/msg/Float64")])


def test_a_topic_stamped_by_another_clock_is_found_by_its_arrival(tmp_path: Path) -> None:
    preflight = pytest.importorskip(
        "er_model_lab.preflight.samples", reason="it judges the arrival"
    )

    def sent(behind: int) -> Iterator[Sent]:
        for s in ticks(600):
            s.stamp -= behind if s.topic == "sensors/force" else 0
            yield s

    def found(name: str, behind: int) -> list[tuple[str, str]]:
        return [
            (f.channel, f.found[:6])
            for f in preflight.wait_findings(one(record_bag(tmp_path / name, list(sent(behind)))))
        ]

    assert found("same", 0) == []
    assert found("other", 40 * TICK + TICK // 2) == [("sensors/force", "+202 m")]
