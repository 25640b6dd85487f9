"""The benchmark of the wire measures two hosts whose wires are in use."""

from __future__ import annotations

from er_studies.bench import wire


def test_with_and_without_a_key_every_sample_of_a_turn_is_taken() -> None:
    plain, sealed = wire.ended(b""), wire.ended(wire.KEY)
    assert (plain.key, len(sealed.key)) == (b"", 16)
    for host in (plain, sealed):
        assert all(
            0.0 < each < 0.1 for each in wire.turn(host, 100)
        )  # which asserts that all came through
