"""Frames and parser: what is sent comes out, whatever the pieces; what is damaged does not."""

import numpy as np
import pytest
from er_plant_sim.hardware import frame, parser
from er_plant_sim.hardware.frame import Command, Hello, Sample, Sync, SyncReply
from er_plant_sim.hardware.parser import ParserState

MESSAGES = (
    Hello(2**32 - 1, 5_000_000, 63, 1, 50_000, 5_000),
    Sample(7, 2**64 - 1, (-(2**31), 2**31 - 1, 0, 1, -1, 5), 63, 50_000, 6, 3, 255),
    Command(7, 15_000, 2, 1, -(2**31)),
    Sync(2**63),
    SyncReply(1, 2, 3),
)
STREAM = b"".join(frame.encode(message, seq) for seq, message in enumerate(MESSAGES))


def test_a_sample_on_the_wire_byte_by_byte() -> None:
    """The example of docs/hardware.md: what another implementation has to produce."""
    data = frame.encode(Command(answers=258, duty=15_000, source=2, flags=1, road=-1), seq=5)
    assert data.hex(" ") == (
        "a5 5a 01 03 0c 00 05 00 00 00 02 01 00 00 98 3a 02 01 ff ff ff ff 21 3e 94 dc"
    )


@pytest.mark.parametrize("size", [1, 2, 3, 7, 59, 1000])
def test_pieces_of_any_size_give_the_same_frames(size: int) -> None:
    state, found = ParserState(), []
    for at in range(0, len(STREAM), size):
        state, more = parser.step(state, STREAM[at : at + size])
        found += more
    assert [each.message for each in found] == list(MESSAGES)
    assert [each.seq for each in found] == list(range(len(MESSAGES)))
    assert state._replace(rest=b"") == ParserState(frames=len(MESSAGES))


def test_all_errors_of_up_to_four_bits_in_a_frame_are_found() -> None:
    """The CRC is linear: such errors pass only if one, two, or two pairs of bits share a syndrome."""
    clean = frame.encode(MESSAGES[1], 1)
    assert len(clean) == frame.LONGEST
    bits = 8 * (len(clean) - len(frame.MARK))
    from zlib import crc32

    def syndrome(bit: int) -> int:
        body = bytearray(len(clean) - len(frame.MARK))
        body[bit // 8] ^= 1 << bit % 8
        data, kept = bytes(body[:-4]), int.from_bytes(body[-4:], "little")
        return crc32(data) ^ crc32(bytes(len(data))) ^ kept

    single = np.array([syndrome(bit) for bit in range(bits)], np.uint32)
    left, right = np.triu_indices(bits, 1)
    pairs = single[left] ^ single[right]
    assert single.all()
    assert pairs.all()
    assert np.unique(pairs).size == pairs.size  # no four bits
    assert not np.isin(single, pairs).any()  # no three bits


def test_another_version_is_named_and_a_duty_above_one_refused() -> None:
    good = frame.encode(MESSAGES[0], 1)
    body = bytes([2]) + good[3:-4]
    from zlib import crc32

    other = frame.MARK + body + frame.CRC.pack(crc32(body))
    state, found = parser.step(ParserState(), other)
    assert (found, state.foreign, state.version) == ([], 1, 2)
    state, found = parser.step(ParserState(), frame.encode(Command(1, 50_001, 2, 0, 0), 1))
    assert (found, state.foreign, state.version) == ([], 1, frame.VERSION)


def test_numbers_that_start_anew_are_still_in_order() -> None:
    assert frame.ahead(1, 2**32 - 1) == 2
    assert frame.ahead(2**32 - 1, 1) == -2
