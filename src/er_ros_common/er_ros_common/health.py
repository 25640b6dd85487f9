"""Health of a node: ``~/status`` at 10 Hz and ``/diagnostics`` at 1 Hz and on change, from one report.

For people and monitors; never the safety path (REP-107).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from time import monotonic
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from er_common.stamps import StampState
from er_models.constants import SAMPLE_TIME
from rclpy.node import Node

from er_common import topics
from er_damper_msgs.msg import NodeStatus
from er_ros_common import builders, clock, log, qos
from er_ros_common.builders import Tick, Timing
from er_ros_common.graph_check import Problem
from er_ros_common.inputs import ERROR, OK, WARN, Finding, Input

NO_STAMPS = StampState()
STATUS_PERIOD, DIAGNOSTICS_PERIOD = 0.1, 1.0
SLOW_WARN, SLOW_ERROR = 0.001, 0.002
"""Mean computing times of a step that are worth a warning and an error, as in ros2_control [s]."""
LATE = 0.01
"""Share of the steps of a second that may take longer than a sample before it is worth a warning."""
SECOND = round(DIAGNOSTICS_PERIOD / STATUS_PERIOD)
"""Looks at the computing times that are judged together: what one look holds comes and goes."""
CALM = 2.0
"""How long all must be well before an entry that was worse is well again [s]; the state is never late."""
_WARN = (
    NodeStatus.STATUS_INITIALIZING,
    NodeStatus.STATUS_DEGRADED,
    NodeStatus.STATUS_OUT_OF_RANGE,
)


@dataclass(frozen=True)
class Report:
    """What a node says of itself; ``problems`` are sentences that need somebody's attention."""

    mode: str
    status: int = NodeStatus.STATUS_OK
    reason: str = ""
    stamps: StampState = NO_STAMPS
    invalid: int = 0
    valid: bool = True
    values: Mapping[str, object] = field(default_factory=dict)
    problems: tuple[str, ...] = ()


@dataclass(slots=True)
class Meter:
    """Step times and outputs, since the start and since the last look."""

    deadline: float
    published: int = 0
    deadline_misses: int = 0
    _since: float = 0.0
    _outputs: int = 0
    _steps: int = 0
    _total: float = 0.0
    _longest: float = 0.0

    def step(self, seconds: float, outputs: int = 1) -> None:
        """Count one step of this length [s] and what it put out."""
        self.published += outputs
        self.deadline_misses += seconds > self.deadline
        self._outputs += outputs
        self._steps += 1
        self._total += seconds
        self._longest = max(self._longest, seconds)

    def look(self, now: float) -> Timing:
        """Figures since the last look at time now [s]; begins the next interval."""
        interval = now - self._since if self._since else 0.0
        timing = Timing(
            published=self.published,
            deadline_misses=self.deadline_misses,
            output_rate=self._outputs / interval if interval > 0.0 else 0.0,
            step_time_mean=self._total / self._steps if self._steps else 0.0,
            step_time_max=self._longest,
        )
        self._since, self._outputs, self._steps, self._total, self._longest = now, 0, 0, 0.0, 0.0
        return timing


class Health:
    """Publishes the status and diagnostics of a node; create it last in the node's constructor.

    inputs: what the node listens to; problems: of the graph around it.
    """

    def __init__(
        self,
        node: Node,
        report: Callable[[], Report],
        *,
        deadline: float = SAMPLE_TIME,
        model_id: str = "",
        gains_id: str = "",
        inputs: Callable[[], Sequence[Input]] = tuple,
        problems: Callable[[], Sequence[Problem]] = tuple,
    ) -> None:
        self.node, self.report, self.meter = node, report, Meter(deadline)
        self.model_id, self.gains_id = model_id, gains_id
        self.inputs, self.problems = inputs, problems
        self._count, self._timing, self._word = 0, Timing(), ""
        self._tasks: dict[str, Shown] = {}
        self._means: deque[float] = deque(maxlen=SECOND)
        self._late: deque[int] = deque(maxlen=SECOND)
        self._sent, self._missed = -DIAGNOSTICS_PERIOD, 0
        self._status = node.create_publisher(
            NodeStatus, topics.STATUS.name, qos.profile(topics.STATUS.publisher)
        )
        self._diagnostics = node.create_publisher(
            DiagnosticArray, topics.DIAGNOSTICS.name, qos.profile(topics.DIAGNOSTICS.publisher)
        )
        # not in simulated time: a simulation that stands still is news
        clock.wall_timer(node, STATUS_PERIOD, self.publish_status)

    def publish_status(self) -> None:
        """Send the status now, and diagnostics when they are due; changes are logged once."""
        said, self._count = self.report(), self._count + 1
        self._timing = self.meter.look(monotonic())
        self._log(said)
        message = builders.node_status(
            Tick(max(clock.now(self.node), 0), self._count),
            self.node.get_fully_qualified_name(),
            said.mode,
            reason=said.reason,
            model_id=self.model_id,
            gains_id=self.gains_id,
            stamps=said.stamps,
            timing=self._timing,
            non_finite=sum(each.non_finite for each in self.inputs()),
            invalid=said.invalid,
            status=said.status,
            valid=said.valid,
        )
        self._status.publish(message)
        self._diagnose(said, monotonic())

    def _log(self, said: Report) -> None:
        word = f"{said.mode}: {said.reason}" if said.reason else said.mode
        if word == self._word:
            return
        log.at_level(self.node, _level(said.status), word)
        self._word = word

    def _diagnose(self, said: Report, now: float) -> None:
        """Send diagnostics once a second, and at once when a level has changed."""
        due = now - self._sent >= DIAGNOSTICS_PERIOD - 0.5 * STATUS_PERIOD
        self._late.append(self.meter.deadline_misses - self._missed)
        self._missed = self.meter.deadline_misses
        if self._timing.step_time_mean:
            self._means.append(self._timing.step_time_mean)
        before, found = self._tasks, self._found(said, now)
        self._tasks = {t.name: settled(before.get(t.name), t, now) for t in found}
        tasks = [each.task for each in self._tasks.values()]
        changed = [t for t in tasks if t.name in before and before[t.name].task.level != t.level]
        for task in changed:
            if task.name != "state":  # which has been logged
                log.at_level(self.node, task.level, f"{task.name}: {task.text}")
        if not due and not changed:
            return
        if due:
            self._sent = now
            for each in self.inputs():
                each.measure(now)
        message = DiagnosticArray()
        message.header.stamp = clock.to_stamp(max(clock.now(self.node), 0))
        node = self.node.get_fully_qualified_name()
        values = self._values(said)
        message.status = [_status(node, task, values[task.name]) for task in tasks]
        self._diagnostics.publish(message)

    def _found(self, said: Report, now: float) -> tuple[Task, ...]:
        """The tasks of diagnostics as they are now."""
        each = self.inputs()
        graph = [Finding(ERROR, p.topic, f"{p.text}: {p.cure}") for p in self.problems()]
        graph += [Finding(ERROR, "", text) for text in said.problems]
        return (
            Task("state", _level(said.status), said.reason or said.mode),
            task("input rate", [i.flow(now) for i in each]),
            task("stamps", [f for i in each for f in i.stamps(now)]),
            task("values", [f for i in each for f in i.values(now)]),
            self._load(),
            task("graph", graph),
        )

    def _load(self) -> Task:
        """Computing times of the last second against the thresholds of ros2_control, and steps not done in time."""
        whole = len(self._means) == SECOND  # the first steps are slow, and few of them say nothing
        mean, late = (sum(self._means) / SECOND, sum(self._late)) if whole else (0.0, 0)
        many = late > max(1.0, LATE * DIAGNOSTICS_PERIOD / self.meter.deadline)
        level = ERROR if mean > SLOW_ERROR else WARN if mean > SLOW_WARN or many else OK
        text = (
            "in time"
            if level == OK
            else f"steps take {1e3 * mean:.2f} ms, {late} were too late: CPU overloaded?"
        )
        return Task("timing", level, text)

    def _values(self, said: Report) -> dict[str, Mapping[str, object]]:
        """What people may want to know beside each task."""
        each, timing = self.inputs(), self._timing
        own = {
            "mode": said.mode,
            "output rate [Hz]": f"{timing.output_rate:.1f}",
            "lost inputs": said.stamps.lost,
        }
        return {
            "state": own | dict(said.values),
            "input rate": {i.name: f"{i.measured:.1f} Hz" for i in each},
            "stamps": {i.name: f"{i.state.received} came, {i.state.lost} lost" for i in each},
            "values": {
                i.name: f"{i.invalid} not valid, {i.non_finite} not finite, {i.incomplete} incomplete"
                for i in each
            },
            "timing": {
                "step time mean [ms]": f"{1e3 * timing.step_time_mean:.3f}",
                "step time max [ms]": f"{1e3 * timing.step_time_max:.3f}",
                "deadline misses": self.meter.deadline_misses,
            },
            "graph": {},
        }


@dataclass(frozen=True)
class Task:
    """One entry of diagnostics: name, level, text."""

    name: str
    level: int
    text: str


class Shown(NamedTuple):
    """An entry as it is shown, and when it was last found to be as bad as that [s]."""

    task: Task
    since: float


def settled(before: Shown | None, found: Task, now: float) -> Shown:
    """What is shown at a time [s]: what is found, but a better level only once it has lasted, so that nothing flaps."""
    better = before is not None and found.level < before.task.level and found.name != "state"
    if better and before is not None and now - before.since < CALM:
        return before
    return Shown(found, now)


def task(name: str, found: Sequence[Finding]) -> Task:
    """The findings of one kind as an entry, the worst first."""
    level = max((f.level for f in found), default=OK)
    worth = sorted((f for f in found if f.level or name == "stamps"), key=lambda f: -f.level)
    text = "; ".join(f"{f.topic}: {f.text}" if f.topic else f.text for f in worth)
    return Task(name, level, text or "as expected")


def _level(status: int) -> int:
    if status == NodeStatus.STATUS_OK:
        return OK
    return WARN if status in _WARN else ERROR


def _status(node: str, entry: Task, values: Mapping[str, object]) -> DiagnosticStatus:
    pairs = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
    namespace = node.rpartition("/")[0] or "/"
    return DiagnosticStatus(
        level=bytes([entry.level]),
        name=f"{node.removeprefix('/')}: {entry.name}",
        message=entry.text,
        hardware_id=namespace,
        values=pairs,
    )
