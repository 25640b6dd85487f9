"""What every node is: a lifecycle node that starts by itself and says how it is.

A node is made of `configure` (files, core, ends of topics), `begin` (from now on it acts), `end` (it leaves
something safe behind, and acts no more) and `report`. Ends of topics are made once and stay: where a node is not
active, what arrives is not handled and timers do nothing. With ``autostart`` false a manager leads it
through the states; else `run` does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from time import monotonic, monotonic_ns, time_ns
from typing import Any

from er_common.common_parameters import NodeParameters
from er_common.quality import Quality
from er_common.stamps import StampLimits
from er_common.topics import Topic
from er_models.errors import ErError
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from rclpy.timer import Timer

from er_damper_msgs.msg import NodeStatus
from er_ros_common import clock, log, qos, realtime
from er_ros_common.core import When
from er_ros_common.graph_check import Problem, endpoints, watch
from er_ros_common.health import Health, Report
from er_ros_common.inputs import Input
from er_ros_common.intra_process import IntraProcess, LocalPublisher, passable
from er_ros_common.makers import reader
from er_ros_common.private import SteadyLifecycleNode

NOT_READY = ("waiting", "unconfigured", "inactive")
"""Modes of a node that does not act yet."""
WAITS = {
    "unconfigured": "waits for a manager (ros2 lifecycle set NODE configure)",
    "inactive": "waits for a manager (ros2 lifecycle set NODE activate)",
    "finalized": "it was shut down for good: start it anew",
}
"""Why a node does not act, by the state it is in."""
GRAPH_PERIOD = 1.0
"""How often a node looks at the graph around it [s]."""


class ManagedNode(SteadyLifecycleNode):
    """Lifecycle, health and ends of topics; subclasses fill the hooks below.

    p: its parameters, declared by the subclass in its constructor, a `NodeParameters`. active: whether it acts;
    local: the way to other nodes of its process, None where it is alone; came: when the last input did.
    """

    def __init__(self, name: str, argv: Sequence[str] | None = None) -> None:
        """argv: command line of this node alone, where a process holds several; None: the process's."""
        own = {} if argv is None else {"cli_args": list(argv), "use_global_arguments": False}
        super().__init__(name, **own)
        self.argv, self.active, self.configured = argv, False, False
        self.failure: ErError | None = None
        self.local: IntraProcess | None = None
        self.came = When(0, None)
        self.add_post_set_parameters_callback(self._follow_time)
        self._follow_time(())
        self._managed = True
        self.problems: list[Problem] = []
        self.watched: dict[str, Topic] = {}
        self._made: dict[str, Any] = {}
        self._answers: dict[str, Callable[[Any, Any], Any]] = {}
        self._heard: dict[str, Callable[[Any], None]] = {}
        self.incoming: dict[str, Input] = {}
        self.health = Health(
            self,
            self._said,
            inputs=lambda: tuple(self.incoming.values()) if self.active else (),
            problems=lambda: self.problems,
        )
        clock.wall_timer(self, GRAPH_PERIOD, self._look)

    # hooks of a node

    def configure(self) -> None:
        """Load files, make the core and the ends of topics; raises `ErError` where that cannot be."""

    def begin(self) -> None:
        """Act from now on, from a fresh state."""

    def end(self) -> None:
        """Leave something safe behind; the last chance to publish."""

    def close(self) -> None:
        """Give back what was configured: at the end, and before it is configured anew."""

    def tune(self, p: Any) -> None:
        """Go on with other dynamic parameters; raises `ErError` where they contradict, before anything is done."""

    def report(self) -> Report:
        """Health while active."""
        raise NotImplementedError

    def changed(self, p: Any) -> None:
        """Take parameters that were set; as `tune` where the node is configured."""
        if self.configured:
            self.tune(p)
        self.p = p

    # tools of a node; each end is made once, however often the node is configured

    def advertise(self, topic: Topic) -> Publisher:
        """Publisher of a topic; the graph around it is watched."""
        self.watched[topic.name] = topic
        return self._once(f"out {topic.name}", lambda: self._publisher(topic))

    def _publisher(self, topic: Topic) -> Publisher:
        offered = qos.profile(topic.publisher)
        given = (topic.type, topic.name, offered)
        if not passable(offered):
            return self.create_publisher(*given)
        made = self.create_publisher(*given, publisher_class=LocalPublisher)
        if self.local is not None:
            self.local.add_publisher(made)
        return made

    def subscribe(
        self,
        topic: Topic,
        heard: Callable[[Any], None],
        asked: Quality | None = None,
        *,
        needed: bool = True,
        whole: bool = False,
        limits: StampLimits | None = None,
        rate: float = 0.0,
    ) -> Subscription:
        """Subscription of a topic, heard while active; the topic and the graph around it are watched.

        needed: whether its silence is a fault; whole: whether a message without one of its parts is of no use;
        limits: when its stamps are bad, None where that is as of all; rate: of the ticks that the node is made for
        [Hz], 0: any.
        """
        self.watched[topic.name] = topic
        name, profile = self.resolve_topic_name(topic.name), qos.profile(asked or topic.subscriber)
        steady = topic.every_tick and self.aged
        limits = limits or self.stamp_limits()
        rate = rate if topic.every_tick else 0.0
        made = Input(name, limits, monotonic(), needed=needed, steady=steady, rate=rate)
        self.incoming[topic.name] = made

        read = reader(topic.type, ("seq", "valid", *topic.numbers))
        lacking = topic.lacking if whole else None

        def noted(message: Any) -> None:
            each = self.incoming.get(topic.name) if self.active else None
            if each is not None:  # else it is of an earlier configuration, or nothing is heard
                self.came = came = self.when()
                sec, nanosec, seq, valid, *numbers = read(message)
                arrival = 1e-9 * came.steady
                each.note(clock.joined(sec, nanosec), seq, arrival, self.stamp_clock())
                each.read(numbers, arrival, valid=valid, lacks=lacking(message) if lacking else "")
                self._heard[topic.name](message)

        self._heard[topic.name] = heard
        return self._once(f"in {topic.name}", lambda: self._subscription(topic, noted, profile))

    def _subscription(
        self, topic: Topic, noted: Callable[[Any], None], asked: QoSProfile
    ) -> Subscription:
        given, local = (topic.type, topic.name), self.local
        if local is None or not passable(asked):
            return self.create_subscription(*given, noted, asked)
        made = self.create_subscription(*given, lambda message: local.turn(noted, message), asked)
        local.add_subscription(made, noted)
        return made

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """Those that an executor has to watch."""
        served = self.local.silent if self.local else ()
        yield from (each for each in super().subscriptions if each not in served)

    def when(self) -> When:
        """Now, on both clocks; simulated time without a clock of its own, as in lockstep, is known by stamps alone."""
        if self.simulated:
            return When(monotonic_ns(), clock.now(self))
        return When(monotonic_ns(), time_ns() if self.aged else None)

    @cached_property
    def aged(self) -> bool:
        """Whether the age of a sample means anything: not in simulated time."""
        return bool(getattr(self.p, "max_age", True))

    def stamp_clock(self) -> int | None:
        """When the last message came on the clock of the stamps [ns], None where ages mean nothing."""
        return self.came.system if self.aged else None

    def stamp_limits(self) -> StampLimits:
        """When a stamp is bad, for diagnostics."""
        return StampLimits(stale=getattr(self.p, "max_age", 0.0) or StampLimits().stale)

    def listen(
        self, name: str, kind: type[Any], heard: Callable[[Any], None], asked: Quality
    ) -> Subscription:
        """Subscription of something that is no input, another node's status for instance: always heard.

        By the last who asked for it: a node that is configured anew has new listeners at the ends that it has.
        """
        self._heard[name] = heard

        def told(message: Any) -> None:
            self._heard[name](message)

        return self._once(
            f"in {name}", lambda: self.create_subscription(kind, name, told, qos.profile(asked))
        )

    def offer(self, kind: type[Any], name: str, asked: Callable[[Any, Any], Any]) -> Any:
        """Service of the node, in every state."""
        self._answers[name] = asked
        return self._once(
            f"service {name}",
            lambda: self.create_service(kind, name, lambda *each: self._answers[name](*each)),
        )

    def every(self, period: float, due: Callable[[], None]) -> Timer:
        """Timer [s] on the steady clock that does nothing while the node is not active."""
        call = self._in_turn(due)
        made: Timer = self._once(
            f"timer {due.__name__}", lambda: clock.wall_timer(self, period, call)
        )
        made.timer_period_ns = round(1e9 * period)  # it may be of an earlier configuration
        return made

    def watch_every(self, period: float, due: Callable[[], None], patience: float = 0.0) -> None:
        """The same for a look that needs no timer of its own: nodes of one process share one.

        patience: how long after a message the look has nothing to say [s]; that of the last call counts.
        """
        local, call = self.local, self._in_turn(due)
        if local is None:
            self.every(period, due)
        else:
            look = self._once(f"timer {due.__name__}", lambda: local.every(period, call))
            local.wait(look, patience)

    def pass_on(self) -> None:
        """Let nodes of this process hear now what was published so far: queues are short, and this goes on for long."""
        if self.local is not None:
            self.local.drain()

    def _in_turn(self, due: Callable[[], None]) -> Callable[[], None]:
        def call() -> None:
            if not self.active:
                return
            if self.local is None:
                due()
            else:
                self.local.turn(due)

        return call

    def _once(self, key: str, make: Callable[[], Any]) -> Any:
        if key not in self._made:
            self._made[key] = make()
        return self._made[key]

    def while_active(self, heard: Callable[[Any], None]) -> Callable[[Any], None]:
        """The callback of a subscription, without what arrives while the node is not active."""

        def call(message: Any) -> None:
            if self.active:
                heard(message)

        return call

    def _follow_time(self, _: Sequence[Parameter[Any]]) -> None:
        """Whether the node's clock is that of a simulation."""
        self.simulated = bool(self.get_parameter("use_sim_time").value)

    def _look(self) -> None:
        look = self.local.endpoints if self.local else endpoints
        self.problems = watch(self, tuple(self.watched.values()), look)

    def _said(self) -> Report:
        if self.active:
            return self.report()
        label = self.state_label
        reason = str(self.failure or WAITS.get(label, label))
        status = NodeStatus.STATUS_LOST if label == "finalized" else NodeStatus.STATUS_INITIALIZING
        return Report(
            label, NodeStatus.STATUS_FAULT if self.failure else status, reason, valid=False
        )

    @property
    def common(self) -> NodeParameters:
        """Parameters that every node has."""
        return self.p

    # the way through the states

    def start(self) -> None:
        """Configure and activate; raises what `configure` raised."""
        # whoever started it says what is wrong; a manager only learns that it failed
        self._managed = False
        for trigger in (self.trigger_configure, self.trigger_activate):
            if trigger() != TransitionCallbackReturn.SUCCESS:
                raise self.failure or ErError(f"{self.get_name()} could not be started")
        self._managed = True

    def on_stop(self) -> None:
        """Called before the node is destroyed, whatever its state."""
        if self.active:
            realtime.give_back(self.get_fully_qualified_name())
            self.end()
        if self.configured:
            self.close()
        self.active = self.configured = False

    def on_configure(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Transition of ROS; what an earlier configuration listened to and said is asked for no more, its ends stay."""
        self.incoming, self.watched = {}, {}
        self.__dict__.pop("aged", None)  # as the parameters may have changed
        with realtime.suspended():
            done = self._tried(self.configure)
        self.configured = done == TransitionCallbackReturn.SUCCESS
        return done

    def on_activate(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Transition of ROS."""
        for each in self.incoming.values():
            each.since, each.arrived = monotonic(), None
        done = self._tried(self.begin)
        self.active = done == TransitionCallbackReturn.SUCCESS
        if self.active and self.common.priority:
            refused = realtime.ask(self.get_fully_qualified_name(), self.common.priority)
            if refused:
                log.warning(self, f"priority {self.common.priority}: {refused}")
        return done

    def on_deactivate(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Transition of ROS."""
        self.active = False
        realtime.give_back(self.get_fully_qualified_name())
        return self._tried(self.end)

    def on_cleanup(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Transition of ROS."""
        self.configured = False
        return self._tried(self.close)

    def on_shutdown(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Transition of ROS; from any state."""
        self.on_stop()
        return TransitionCallbackReturn.SUCCESS

    def _tried(self, action: Callable[[], None]) -> TransitionCallbackReturn:
        """Refuse the transition where the action cannot be done, with the line that says why."""
        self.failure, done = None, TransitionCallbackReturn.SUCCESS
        try:
            action()
        except ErError as error:
            self.failure, done = error, TransitionCallbackReturn.FAILURE
        except Exception as error:  # rclpy would not say a word of it
            self.failure = ErError(" ".join(f"{type(error).__name__}: {error}".split()))
            done = TransitionCallbackReturn.ERROR
        if self.failure and self._managed:
            log.warning(self, str(self.failure))
        return done
