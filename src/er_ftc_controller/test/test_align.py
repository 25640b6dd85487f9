"""Joining two topics by stamp."""

from er_ftc_controller.align import DEPTH, Aligner


def test_pairs_in_either_order() -> None:
    pairs: Aligner[str, str] = Aligner()
    pairs, pair = pairs.with_left(10, "a10")
    assert pair is None
    pairs, pair = pairs.with_right(10, "d10")
    assert pair == ("a10", "d10")
    pairs, pair = pairs.with_right(15, "d15")
    assert pair is None
    pairs, pair = pairs.with_left(15, "a15")
    assert pair == ("a15", "d15")
    assert (dict(pairs.left), dict(pairs.right), pairs.unmatched) == ({}, {}, 0)


def test_a_lost_partner_is_counted_and_does_not_block() -> None:
    pairs: Aligner[str, str] = Aligner()
    pairs, _ = pairs.with_left(10, "a10")
    pairs, _ = pairs.with_left(15, "a15")
    pairs, pair = pairs.with_right(15, "d15")
    assert pair == ("a15", "d15")
    assert pairs.unmatched == 1
    assert not pairs.left


def test_what_waits_is_bounded() -> None:
    pairs: Aligner[int, int] = Aligner()
    for k in range(DEPTH + 7):
        pairs, _ = pairs.with_left(k, k)
    assert sorted(pairs.left) == list(range(7, DEPTH + 7))
    assert pairs.unmatched == 7


def test_time_that_jumps_back_forgets_what_waits() -> None:
    pairs: Aligner[int, int] = Aligner()
    for k in range(DEPTH):
        pairs, _ = pairs.with_left(1000 + k, k)
    pairs, _ = pairs.with_left(5, 7, back=True)
    assert dict(pairs.left) == {5: 7}
    assert pairs.unmatched == DEPTH
    assert pairs.with_right(5, 8)[1] == (7, 8)
