"""Joining accelerations with the duty applied from then on."""

import math

from er_observers.feed import DEPTH, Feed, Motion, feed_of, on_deflection, on_duty, on_motion


def motion(stamp: int) -> Motion:
    """Accelerations of a tick."""
    return Motion(stamp, stamp, 0.1 * stamp, -0.1 * stamp)


def test_in_order() -> None:
    feed, ready = on_motion(Feed(), motion(5))
    assert ready == []
    feed, ready = on_duty(feed, 5, 0.2)
    assert [r[:2] for r in ready] == [(motion(5), 0.2)]
    assert feed.waiting is None


def test_the_duty_may_come_first() -> None:
    feed, ready = on_duty(Feed(), 5, 0.2)
    assert ready == []
    feed, ready = on_motion(feed, motion(5))
    assert [r[:2] for r in ready] == [(motion(5), 0.2)]
    assert not feed.duties


def test_a_lost_duty_holds_nothing_up() -> None:
    feed, _ = on_motion(Feed(), motion(5))
    feed, ready = on_motion(feed, motion(10))
    assert [r.motion for r in ready] == [motion(5)]
    assert math.isnan(ready[0].duty)
    assert feed.lost == 1
    feed, ready = on_duty(feed, 5, 0.3)
    assert ready == []
    feed, ready = on_duty(feed, 10, 0.2)
    assert [r[:2] for r in ready] == [(motion(10), 0.2)]


def test_lost_accelerations_leave_nothing_behind() -> None:
    feed = Feed()
    for stamp in range(1, 4 * DEPTH):
        feed, _ = on_duty(feed, stamp, 0.1)
    assert len(feed.duties) == DEPTH
    feed, ready = on_motion(feed, motion(4 * DEPTH - 1))
    assert ready[0].duty == 0.1
    assert not feed.duties


def test_a_deflection_is_waited_for_where_it_is_needed() -> None:
    feed, _ = on_motion(feed_of(deflection=True), motion(5))
    feed, ready = on_duty(feed, 5, 0.2)
    assert ready == []
    feed, ready = on_deflection(feed, 5, 1e-3)
    assert ready == [(motion(5), 0.2, 1e-3)]
    assert (feed.waiting, dict(feed.duties), dict(feed.deflections or {})) == (None, {}, {})


def test_a_lost_deflection_holds_nothing_up() -> None:
    feed, _ = on_motion(feed_of(deflection=True), motion(5))
    feed, _ = on_duty(feed, 5, 0.2)
    feed, _ = on_deflection(feed, 10, 2e-3)
    feed, ready = on_motion(feed, motion(10))
    assert ready[0][:2] == (motion(5), 0.2)
    assert math.isnan(ready[0].deflection)
    assert (feed.lost, feed.blind) == (0, 1)
    feed, ready = on_duty(feed, 10, 0.3)
    assert ready == [(motion(10), 0.3, 2e-3)]


def test_time_that_jumps_back_forgets_what_is_kept() -> None:
    feed = feed_of(deflection=True)
    for k in range(DEPTH):
        feed, _ = on_duty(feed, 1000 + k, 0.3)
        feed, _ = on_deflection(feed, 1000 + k, 1e-3)
    feed, _ = on_duty(feed, 5, 0.2, back=True)
    feed, _ = on_deflection(feed, 5, 2e-3, back=True)
    assert on_motion(feed, motion(5))[1] == [(motion(5), 0.2, 2e-3)]


def test_a_deflection_that_may_be_missing_is_waited_for_while_it_comes() -> None:
    feed, ready = on_motion(feed_of(deflection=True, needed=False), motion(5))
    feed, ready = on_duty(feed, 5, 0.2)
    assert ready[0].motion == motion(5)
    feed, _ = on_deflection(feed, 5, 1e-3)  # comes late: from now on it is waited for
    feed, _ = on_motion(feed, motion(10))
    feed, ready = on_duty(feed, 10, 0.2)
    assert ready == []
    feed, ready = on_deflection(feed, 10, 2e-3)
    assert ready == [(motion(10), 0.2, 2e-3)]
    feed, _ = on_motion(feed, motion(15))
    feed, _ = on_duty(feed, 15, 0.2)
    feed, ready = on_motion(feed, motion(20))
    assert math.isnan(ready[0].deflection)
    feed, ready = on_duty(feed, 20, 0.2)
    assert ready[0].motion == motion(20)
