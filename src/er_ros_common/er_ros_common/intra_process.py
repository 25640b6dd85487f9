"""Messages between nodes of one process, handed over as they are: not packed, not sent, not unpacked.

To the rest of the graph nothing is different. Every end is a publisher or subscription of the middleware, too, and a
message also goes that way as soon as somebody outside listens. A subscription is served *directly* while all its
publishers are in this process; the middleware's copies then stay unread. When an outside publisher appears, it is
served by the middleware alone, so that nothing comes twice and the order is that of the middleware.

A message that was published is given to several nodes: nobody may change it.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from threading import get_ident
from time import monotonic
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSCompatibility,
    QoSProfile,
    qos_check_compatible,
)
from rclpy.subscription import Subscription
from rclpy.timer import Timer

from er_ros_common import clock
from er_ros_common.graph_check import Ends, endpoints

LOOK_PERIOD = 0.1
"""How often it is looked whether somebody outside has come or gone [s]."""
SEEN = 0.5
"""How long what one node has seen of a topic in the graph serves the others [s]."""
SLACK = 1e-6
"""What a multiple of a period may lack, rounded as periods are."""
EARLY = 0.9
"""Part of a period after which messages that come once a period make a round, a little sooner now and then."""
MOST = 200
"""Messages in one go; then timers and signals get their turn."""


@dataclass(slots=True)
class Look:
    """Something to be called each period [s]; patience: how long after a message it has nothing to say [s].

    left: rounds until it is called.
    """

    due: Callable[[], None]
    period: float
    patience: float = 0.0
    left: int = 1


class LocalPublisher(Publisher):
    """Hands messages to the subscriptions of its process, and sends them only where somebody else listens.

    local: the way through its process; subscriptions: those that are served directly; others: whether there were more
    when they were last counted.
    """

    local: IntraProcess | None = None
    subscriptions: tuple[LocalSubscription, ...] = ()
    others: bool = True

    def get_subscription_count(self) -> int:
        """Subscriptions of the topic, here and elsewhere."""
        count = super().get_subscription_count()
        self.others = count > len(self.subscriptions)
        return count

    def publish(self, message: Any) -> None:
        """Publish a message; TypeError where it is of another type."""
        if not isinstance(message, self.msg_type):
            raise TypeError(f"expected {self.msg_type.__name__}, found {type(message).__name__}")
        if self.local is None:
            self.get_subscription_count()
        elif self.subscriptions:
            self.local.hand(self.subscriptions, message)
        # what is not latched and has no reader is lost anyway
        if self.others:
            super().publish(message)


class LocalSubscription:
    """A subscription of this process.

    heard: what is called with a message; waiting: messages handed over, at most the depth of its quality of service;
    publishers: publishers of the process that it can hear; direct: whether it is served without the middleware; due,
    had: turns to hear a message that it was given, and those that it had.
    """

    def __init__(self, subscription: Subscription, heard: Callable[[Any], None]) -> None:
        self.subscription, self.heard = subscription, heard
        self.waiting: deque[Any] = deque(maxlen=subscription.qos_profile.depth)
        self.publishers: list[LocalPublisher] = []
        self.direct, self.due, self.had = False, 0, 0

    def served_by(self, publisher: LocalPublisher) -> bool:
        """Whether the middleware would connect it to this publisher."""
        s = self.subscription
        same = publisher.msg_type is s.msg_type and publisher.topic_name == s.topic_name
        return same and _compatible(publisher.qos_profile, s.qos_profile)

    @property
    def alone(self) -> bool:
        """Whether its publishers are those of this process, all of them."""
        own = len(self.publishers)
        return own > 0 and self.subscription.get_publisher_count() <= own

    def unread(self) -> Iterable[Any]:
        """What the middleware has for it, taken."""
        handle, kind = self.subscription.handle, self.subscription.msg_type
        with handle:
            while (taken := handle.take_message(kind, False)) is not None:
                yield taken[0]


class IntraProcess:
    """The ends of all nodes of a process that share one executor and one thread, which hears; any may publish.

    order: whose turn it is. Without a lock every message has its turn, as `hand` and `drain` count too few rather than
    too many turns to come: one without a message costs nothing, a message without one would make all after it late.

    looks: what is called each period, all of it on one timer, as each that is due wakes the executor. While messages
    come they make the rounds on the way, and the timer only has to be there before any look is out of patience.
    """

    def __init__(self, nodes: Iterable[Node]) -> None:
        self.nodes = tuple(nodes)
        self.publishers: list[LocalPublisher] = []
        self.subscriptions: list[LocalSubscription] = []
        self.order: deque[LocalSubscription] = deque()
        self.silent: set[Subscription] = set()
        self.turns, self.asked, self.thread = 0, False, get_ident()
        self.seen: dict[str, tuple[float, Ends]] = {}
        self.looks: list[Look] = []
        self.timer: Timer | None = None
        self.period = self.calm = self.pace = math.inf
        self.moved, self.next_round, self.looking = monotonic(), 0.0, False
        self.every(LOOK_PERIOD, self.look)

    def every(self, period: float, due: Callable[[], None]) -> Look:
        """Call something each period [s] or sooner."""
        look = Look(due, period)
        self.looks.append(look)
        self.wait(look, 0.0)
        if period < self.period:
            if self.timer is not None:
                self.nodes[0].destroy_timer(self.timer)
            self.period = self.pace = period
            self.timer = clock.wall_timer(self.nodes[0], period, self._awake)
        return look

    def wait(self, look: Look, patience: float) -> None:
        """How long after a message a look has nothing to say [s]."""
        look.patience = patience
        self.calm = min(max(each.period, each.patience) for each in self.looks)

    def _awake(self) -> None:
        """Make a round where messages stay away, and be back when it may be needed."""
        now = monotonic()
        quiet = now - self.moved >= self.period
        pace = self.period if quiet else self.calm
        if pace != self.pace and self.timer is not None:
            self.pace = pace
            self.timer.timer_period_ns = round(1e9 * pace)
            self.timer.reset()
        if quiet or now >= self.next_round:
            self._look_around(now)

    def _look_around(self, now: float) -> None:
        """Make a round at a time [s]."""
        self.next_round, self.looking = now + EARLY * self.period, True
        try:
            for each in self.looks:
                each.left -= 1
                if each.left <= 0:
                    each.left = int(each.period / self.period + SLACK)
                    each.due()
        finally:
            self.looking = False

    def add_publisher(self, publisher: LocalPublisher) -> None:
        """Take in a new publisher."""
        publisher.local = self
        self.publishers.append(publisher)
        for each in self.subscriptions:
            if each.served_by(publisher):
                each.publishers.append(publisher)
        self.look()

    def add_subscription(self, subscription: Subscription, heard: Callable[[Any], None]) -> None:
        """Take in a new subscription."""
        each = LocalSubscription(subscription, heard)
        each.publishers = [publisher for publisher in self.publishers if each.served_by(publisher)]
        self.subscriptions.append(each)
        self.look()

    def endpoints(self, node: Node, name: str) -> Ends:
        """Ends of a topic as `graph_check.endpoints` finds them, which is slow: once for all nodes that ask in turn."""
        now = monotonic()
        when, ends = self.seen.get(name, (-SEEN, ([], [])))
        if now - when >= SEEN:
            ends = endpoints(node, name)
            self.seen[name] = now, ends
        return ends

    def look(self) -> None:
        """Serve directly, or by the middleware, as publishers and listeners outside come and go."""
        changed = [each for each in self.subscriptions if each.alone != each.direct]
        for each in changed:
            self._turn_over(each)
        if changed:
            for publisher in self.publishers:
                publisher.subscriptions = tuple(
                    e for e in self.subscriptions if e.direct and publisher in e.publishers
                )
            self._wake()
        for publisher in self.publishers:
            publisher.get_subscription_count()

    def _turn_over(self, each: LocalSubscription) -> None:
        """From direct to the middleware, or back."""
        each.direct = not each.direct
        if each.direct:
            for message in each.unread():
                self.hand((each,), message)
            self.silent.add(each.subscription)
            return
        # copies of what was handed over, heard already
        for _ in each.unread():
            pass
        self.silent.discard(each.subscription)

    def hand(self, subscriptions: Iterable[LocalSubscription], message: Any) -> None:
        """Queue a message for the subscriptions; the oldest makes room where a queue is full."""
        for each in subscriptions:
            each.waiting.append(message)
            if each.due - each.had < (each.waiting.maxlen or 0):
                self.order.append(each)
                each.due += 1
        if not self.turns or get_ident() != self.thread:
            self._later()

    def turn(self, call: Callable[..., None], *given: Any) -> None:
        """Call something that may publish; what it published is heard at its end, the order kept."""
        self.turns += 1
        try:
            call(*given)
        finally:
            self.turns -= 1
        if self.turns:
            return
        if self.order:
            self.drain()
        if not self.looking:
            self.moved = now = monotonic()
            if now >= self.next_round:
                self._look_around(now)

    def drain(self) -> None:
        """Hear what waits, and what is published meanwhile."""
        self.asked, self.thread = False, get_ident()
        self.turns += 1
        try:
            for _ in range(MOST):
                if not self.order:
                    return
                each = self.order.popleft()
                each.had += 1
                if each.waiting:
                    each.heard(each.waiting.popleft())
        finally:
            self.turns -= 1
        self._later()

    def _later(self) -> None:
        """Let the executor drain."""
        executor = self.nodes[0].executor
        if executor is not None and not self.asked:
            self.asked = True
            executor.create_task(self.drain)

    def _wake(self) -> None:
        """Let the executor see which subscriptions it has to watch."""
        executor = self.nodes[0].executor
        if executor is not None:
            executor.wake()


def passable(profile: QoSProfile) -> bool:
    """Whether messages of this quality can be handed over: what is latched is kept by the middleware."""
    volatile = profile.durability == DurabilityPolicy.VOLATILE
    return volatile and profile.history == HistoryPolicy.KEEP_LAST


def _compatible(offered: QoSProfile, asked: QoSProfile) -> bool:
    return bool(qos_check_compatible(offered, asked)[0] != QoSCompatibility.ERROR)
