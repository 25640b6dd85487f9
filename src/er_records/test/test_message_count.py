"""Sequence numbers read from serialized messages, and what they say was lost."""

import struct

import pytest
from er_records.recording.message_count import Count, count, header_of


def serialized(seq: int, frame: str = "", order: str = "<") -> bytes:
    """A message of this project as CDR: encapsulation, header, sequence number."""
    text = frame.encode() + b"\0"
    body = struct.pack(f"{order}iII", 7, 250_000_000, len(text)) + text
    body += b"\0" * (-len(body) % 8) + struct.pack(f"{order}Qd", seq, 1.5)
    return bytes([0, 1 if order == "<" else 0, 0, 0]) + body


@pytest.mark.parametrize("frame", ["", "a", "abc", "abcdefgh", "front_left"])
@pytest.mark.parametrize("order", ["<", ">"])
def test_header_and_number_are_read(frame: str, order: str) -> None:
    assert header_of(serialized(2**40 + 3, frame, order)) == (7_250_000_000, 2**40 + 3)


def test_the_reading_agrees_with_ros() -> None:
    serialization = pytest.importorskip("rclpy.serialization")
    messages = pytest.importorskip("er_damper_msgs.msg")
    for kind in (
        messages.PwmDuty,
        messages.DamperForce,
        messages.NodeStatus,
        messages.FaultEstimate,
    ):
        message = kind(seq=77)
        message.header.stamp.sec, message.header.stamp.nanosec = 5, 6
        assert header_of(serialization.serialize_message(message)) == (5_000_000_006, 77)


@pytest.mark.parametrize(
    "data", [b"", b"\0\1\0\0", serialized(1)[:20], b"\0\7" + serialized(1)[2:]]
)
def test_too_short_or_foreign_is_none(data: bytes) -> None:
    assert header_of(data) is None


def counted(*numbers: int) -> Count:
    """The count after these sequence numbers."""
    state = Count()
    for number in numbers:
        state = count(state, number)
    return state


@pytest.mark.parametrize(
    ("numbers", "lost", "repeated", "restarts"),
    [
        ((1, 2, 3), 0, 0, 0),
        ((40, 41, 42), 0, 0, 0),
        ((1, 2, 5, 6, 10), 5, 0, 0),
        ((1, 2, 2, 3, 2, 4), 0, 2, 0),
        ((998, 999, 1, 2), 0, 0, 1),
        ((0, 0, 0), 0, 0, 0),
    ],
)
def test_losses(numbers: tuple[int, ...], lost: int, repeated: int, restarts: int) -> None:
    state = counted(*numbers)
    assert (state.lost, state.repeated, state.restarts) == (lost, repeated, restarts)
    assert state.received == len(numbers)
