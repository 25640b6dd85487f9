"""Damaged frames never pass and never hide a whole one; and the study sees a parser that would let them."""

from __future__ import annotations

import pytest
from er_plant_sim.hardware import parser

from er_studies import damaged_frames


@pytest.mark.parametrize("sealed", [False, True])
def test_damage_of_every_kind_never_passes_and_never_hides_a_whole_frame(sealed: bool) -> None:
    wire = damaged_frames.sealed_wire() if sealed else damaged_frames.PLAIN
    tally = damaged_frames.run(20_000, seed=4, wire=wire)
    assert tally.sound, tally
    assert min(tally.damages.values()) > 200
    assert len(tally.damages) == 8 + sealed
    assert tally.readings > 1000


def test_the_fuzzing_sees_a_parser_that_does_not_look_at_the_crc(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(parser, "crc32", lambda data: int.from_bytes(b"\0" * 4, "little"))
    assert not damaged_frames.run(200, seed=4).sound


def test_the_fuzzing_sees_a_parser_that_does_not_look_at_the_tag(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(parser.seal, "fitting", lambda keys, body, found: keys[-1])
    assert not damaged_frames.run(200, seed=4, wire=damaged_frames.sealed_wire()).sound
