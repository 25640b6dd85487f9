"""Messages within one process: heard once, in order, as soon as published; outside nothing looks different."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Callable, Iterator
from functools import partial
from time import monotonic, process_time
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rclpy")

import rclpy
from er_common.common_parameters import NodeParameters
from er_common.topics import ACCELERATION, PWM_COMMAND
from er_ros_common.builders import Tick
from er_ros_common.health import Report
from er_ros_common.intra_process import (
    LOOK_PERIOD,
    IntraProcess,
    LocalPublisher,
    LocalSubscription,
)
from er_ros_common.managed import ManagedNode
from er_ros_common.spin import make_executor
from rclpy.executors import Executor
from rclpy.node import Node

from er_ros_common import builders
from test.graph_help import own_domain


class Talker(ManagedNode):
    """Publishes a sample when it is told to."""

    def __init__(self, name: str) -> None:
        super().__init__(name, [])
        self.p = NodeParameters()

    def configure(self) -> None:
        """One end."""
        self.out = self.advertise(ACCELERATION)

    def report(self) -> Report:
        """Well."""
        return Report("running")

    def say(self, seq: int) -> Any:
        """Publish; the message."""
        message = builders.suspension_acceleration(Tick(seq * 5_000_000, seq), 1.0, 2.0)
        self.out.publish(message)
        return message


class Echo(Talker):
    """Answers a sample with a duty; keeps what it hears."""

    def configure(self) -> None:
        """Both ends."""
        self.heard: list[Any] = []
        self.answer = self.advertise(PWM_COMMAND)
        self.input = self.subscribe(ACCELERATION, self.on_sample)

    def on_sample(self, message: Any) -> None:
        """Answer."""
        self.heard.append(message)
        self.answer.publish(builders.pwm_duty(Tick(message.seq * 5_000_000, message.seq), 0.1))


class Taker(Talker):
    """Hears duties."""

    def configure(self) -> None:
        """One end."""
        self.heard: list[Any] = []
        self.subscribe(PWM_COMMAND, self.heard.append)


class World:
    """Three nodes of one process with an local, and somebody outside, who is another participant."""

    def __init__(self, domain: int, kind: str) -> None:
        rclpy.init(args=[], domain_id=domain)
        self.nodes = (Talker("talker"), Echo("echo"), Taker("taker"))
        self.talker, self.echo, self.taker = self.nodes
        self.local = IntraProcess(self.nodes)
        self.executor = make_executor(self.talker, kind)
        for node in self.nodes:
            node.local = self.local
            self.executor.add_node(node)
            node.start()
        self.context = rclpy.Context()
        rclpy.init(args=[], context=self.context, domain_id=domain)
        self.outside = Node("outside", context=self.context)
        self.ears: Executor = rclpy.executors.SingleThreadedExecutor(context=self.context)
        self.ears.add_node(self.outside)

    def until(self, there: Callable[[], object], seconds: float = 60.0) -> None:
        """Run callbacks until something is true."""
        end = monotonic() + seconds
        while not there():
            assert monotonic() < end, "it did not come"
            self.executor.spin_once(timeout_sec=0.01)
            self.ears.spin_once(timeout_sec=0.001)

    def idle(self, seconds: float = 0.3) -> None:
        """Run callbacks for a while."""
        end = monotonic() + seconds
        self.until(lambda: monotonic() > end)

    def close(self) -> None:
        """End."""
        for node in (*self.nodes, self.outside):
            node.destroy_node()
        rclpy.try_shutdown()
        self.context.try_shutdown()


@pytest.fixture(params=["events", "single"])
def world(request: pytest.FixtureRequest) -> Iterator[World]:
    """Three nodes in a domain of their own."""
    with own_domain() as env:
        made = World(int(env["ROS_DOMAIN_ID"]), request.param)
        yield made
        made.close()


def seqs(heard: list[Any]) -> list[int]:
    """Their sequence numbers."""
    return [int(m.seq) for m in heard]


def test_a_message_is_handed_over_as_it_is_once_and_in_order(world: World) -> None:
    said: list[Any] = []
    world.local.turn(lambda: said.extend(world.talker.say(k) for k in (1, 2, 3)))
    # at the end of the turn, the answers too, without the executor
    assert all(a is b for a, b in zip(said, world.echo.heard, strict=True))
    assert seqs(world.taker.heard) == [1, 2, 3]
    world.idle()
    assert seqs(world.echo.heard) == [1, 2, 3]
    # and outside a turn as soon as the executor runs
    world.talker.say(4)
    assert seqs(world.echo.heard) == [1, 2, 3]
    world.until(lambda: len(world.echo.heard) == 4)
    # a queue has the depth of its subscription: the newest stay
    world.local.turn(lambda: [world.talker.say(k) for k in range(10, 40)])
    assert seqs(world.echo.heard[4:]) == list(range(40 - ACCELERATION.subscriber.depth, 40))
    with pytest.raises(TypeError, match="expected SuspensionAcceleration, found PwmDuty"):
        world.talker.out.publish(PWM_COMMAND.type())


def test_somebody_outside_hears_all_and_sees_the_graph_and_nobody_hears_twice(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent: list[int] = []
    send = rclpy.publisher.Publisher.publish

    def counted(self: Any, message: Any) -> None:
        if isinstance(self, LocalPublisher):
            sent.append(int(message.seq))
        send(self, message)

    monkeypatch.setattr("rclpy.publisher.Publisher.publish", counted)
    for kind, name in ((ACCELERATION, "sensors/acceleration"), (PWM_COMMAND, "pwm/command")):
        world.until(lambda n=name: world.outside.count_publishers(n) == 1)
        world.until(lambda n=name: world.outside.count_subscribers(n) == 1)
        assert world.talker.count_subscribers(name) == 1, kind.name
    world.talker.say(1)
    world.until(lambda: world.taker.heard)
    assert not sent
    heard: list[Any] = []
    ear = world.outside.create_subscription(ACCELERATION.type, ACCELERATION.name, heard.append, 10)
    world.until(lambda: world.talker.out.get_subscription_count() == 2)
    for k in (2, 3, 4):
        world.talker.say(k)
    world.until(lambda: len(heard) == 3)
    world.idle()
    assert seqs(heard) == sent == [2, 3, 4]
    assert seqs(world.echo.heard) == [1, 2, 3, 4]
    world.outside.destroy_subscription(ear)
    world.until(lambda: world.talker.out.get_subscription_count() == 1)
    world.talker.say(5)
    world.until(lambda: len(world.echo.heard) == 5)
    assert sent == [2, 3, 4]


def test_a_publisher_outside_is_heard_too_while_it_is_there(world: World) -> None:
    world.talker.say(1)
    world.until(lambda: world.echo.heard)
    other = world.outside.create_publisher(ACCELERATION.type, ACCELERATION.name, 10)
    world.until(lambda: world.echo.input.get_publisher_count() == 2)
    world.until(lambda: not world.talker.out.subscriptions)
    world.until(lambda: other.get_subscription_count() == 1)
    for k in (2, 3):
        world.talker.say(k)
        other.publish(builders.suspension_acceleration(Tick(k * 5_000_000 + 1, 100 + k), 3.0, 4.0))
    world.until(lambda: len(world.echo.heard) >= 5)
    world.idle()
    assert sorted(seqs(world.echo.heard)) == [1, 2, 3, 102, 103]
    world.outside.destroy_publisher(other)
    world.until(lambda: world.talker.out.subscriptions)
    last = world.talker.say(4)
    world.until(lambda: len(world.echo.heard) == 6)
    assert world.echo.heard[-1] is last


def test_messages_that_call_for_messages_leave_time_for_timers(world: World) -> None:
    ticks: list[float] = []
    world.talker.create_timer(0.01, lambda: ticks.append(process_time()))
    talker = world.talker
    # every answer is the next sample, for ever
    again = {"on": True}

    def heard(message: Any) -> None:
        if again["on"]:
            talker.say(int(message.seq) + 1)

    world.local.subscriptions[0].heard = heard
    talker.say(1)
    world.until(lambda: len(ticks) >= 5)
    again["on"] = False
    # what was on its way ends, however busy the machine
    world.until(lambda: not world.local.order)


class Between(deque[Any]):
    """A queue where something comes in between, once: before `append`, before or after `popleft`."""

    comes: Callable[[], None] | None = None
    where = ""

    def came(self, where: str) -> None:
        """Let it come if this is its place."""
        if self.comes is not None and where == self.where:
            comes, self.comes = self.comes, None
            comes()

    def append(self, message: Any) -> None:
        """Take one in."""
        self.came("append")
        super().append(message)

    def popleft(self) -> Any:
        """Give one out."""
        self.came("popleft")
        first = super().popleft()
        self.came("popped")
        return first


def test_what_goes_on_for_long_may_be_heard_on_the_way(world: World) -> None:
    """A plant that was held up publishes many samples in one go, and queues are short."""
    world.until(lambda: world.local.silent)

    def held_up(*, passing: bool) -> None:
        for seq in range(1, 31):
            world.talker.say(seq)
            if passing:
                world.talker.pass_on()

    for passing, heard in ((True, 30), (False, 5)):
        begun, answered = len(world.echo.heard), len(world.taker.heard)
        world.local.turn(partial(held_up, passing=passing))
        world.idle()
        assert len(world.echo.heard) - begun == heard
        assert len(world.taker.heard) - answered == heard


def test_all_looks_share_a_timer_and_stop_with_their_node(world: World) -> None:
    """Each wakes the executor: a graph of six had 520 a second. The last that asks may ask for the shortest period."""
    counts = dict.fromkeys(("talker", "echo", "taker"), 0)

    def timers() -> int:
        return sum(len(list(node.timers)) for node in world.nodes)

    before = timers()
    for node, period in zip(world.nodes, (0.06, 0.05, 0.02), strict=True):

        def look(name: str = node.get_name()) -> None:
            counts[name] += 1

        node.watch_every(period, look)
        world.idle()
    assert timers() == before
    counts.update(dict.fromkeys(counts, 0))
    world.until(lambda: counts["talker"] >= 5)
    assert abs(counts["taker"] - 3 * counts["talker"]) <= 3
    # every second call: a look comes rather too soon than too late
    assert abs(counts["echo"] - counts["taker"] / 2) <= 1
    world.echo.trigger_deactivate()
    counts["echo"] = 0
    world.idle()
    assert counts["echo"] == 0


@pytest.mark.alone
def test_while_messages_come_looks_ride_on_them(world: World) -> None:
    """Nobody is woken for them, and soon after the last message they come by themselves again."""
    looks: list[float] = []
    woken: list[float] = []
    local, awake = world.local, world.local._awake

    def counted() -> None:
        woken.append(monotonic())
        awake()

    local._awake = counted  # type: ignore[method-assign]
    world.taker.watch_every(0.02, lambda: looks.append(monotonic()), patience=0.3)
    world.idle()
    counts = itertools.count(1)
    world.talker.every(0.005, lambda: world.talker.say(next(counts)) and None)
    world.idle()
    for each in (looks, woken):
        each.clear()
    world.idle(1.0)
    # by the look at who is outside, which waits for no silence
    assert len(woken) <= 1.0 / LOOK_PERIOD + 2
    assert len(looks) > 3 * len(woken)
    world.talker.trigger_deactivate()
    last = monotonic()
    world.until(lambda: len([each for each in looks if each > last]) >= 5)
    first, *_, fifth = (each for each in looks if each > last)
    assert first - last < LOOK_PERIOD + 0.1
    assert fifth - first < 0.2


@pytest.mark.parametrize("before", [0, 1, 3])
@pytest.mark.parametrize("queue", ["waiting", "order"])
@pytest.mark.parametrize("where", ["append", "popleft", "popped"])
def test_no_message_is_late_whatever_comes_in_between(where: str, queue: str, before: int) -> None:
    heard: list[Any] = []
    subscription: Any = SimpleNamespace(qos_profile=SimpleNamespace(depth=3))
    each = LocalSubscription(subscription, heard.append)
    local = IntraProcess.__new__(IntraProcess)
    vars(local).update(nodes=(SimpleNamespace(executor=None),), turns=0, asked=False, thread=0)
    each.waiting, local.order = Between(maxlen=3), Between()
    for k in range(before):
        local.hand((each,), k)
    between: Any = each.waiting if queue == "waiting" else local.order
    between.where = where
    # while it is published another thread hears; while it is heard another one publishes
    between.comes = local.drain if where == "append" else lambda: local.hand((each,), 3)
    local.hand((each,), 4)
    local.drain()
    assert 4 in heard
    for k in range(5, 15):
        local.hand((each,), k)
        local.drain()
        assert heard[-1] == k
    assert not local.order
    assert not each.waiting
