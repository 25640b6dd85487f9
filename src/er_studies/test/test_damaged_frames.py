"""Damaged frames never pass and never hide a whole one; and the study sees a parser that would let them."""

from __future__ import annotations

import pytest
from er_plant_sim.hardware import parser

from er_studies import damaged_frames


def test_damage_of_every_kind_never_passes_and_never_hides_a_whole_frame() -> None:
    tally = damaged_frames.run(20_000, seed=4)
    assert tally.sound, tally
    assert min(tally.damages.values()) > 200
    assert tally.readings > 1000


def test_the_fuzzing_sees_a_parser_that_does_not_look_at_the_crc(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(parser, "crc32", lambda data: int.from_bytes(b"\0" * 4, "little"))
    assert not damaged_frames.run(200, seed=4).sound
