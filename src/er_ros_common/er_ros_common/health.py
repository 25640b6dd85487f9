"""Health of a node: ``~/status`` at 10 Hz and ``/diagnostics`` at 1 Hz, from one report.

For people and monitors; never the safety path (REP-107).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from time import monotonic

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from er_damper_msgs.msg import NodeStatus
from er_ros_common import builders, clock, log, topics
from er_ros_common.builders import Tick, Timing
from er_ros_common.stamps import StampState

NO_STAMPS = StampState()
STATUS_PERIOD, DIAGNOSTICS_PERIOD = 0.1, 1.0
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
    non_finite: int = 0
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
    """Publishes the status and diagnostics of a node; create it last in the node's constructor."""

    def __init__(
        self,
        node: Node,
        report: Callable[[], Report],
        *,
        deadline: float = 0.005,
        model_id: str = "",
        gains_id: str = "",
    ) -> None:
        self.node, self.report, self.meter = node, report, Meter(deadline)
        self.model_id, self.gains_id = model_id, gains_id
        self._count, self._timing, self._word = 0, Timing(), ""
        self._status = node.create_publisher(
            NodeStatus, topics.STATUS.name, topics.STATUS.publisher
        )
        self._diagnostics = node.create_publisher(
            DiagnosticArray, topics.DIAGNOSTICS.name, topics.DIAGNOSTICS.publisher
        )
        # not in simulated time: a simulation that stands still is news
        clock.wall_timer(node, STATUS_PERIOD, self.publish_status)
        clock.wall_timer(node, DIAGNOSTICS_PERIOD, self._publish_diagnostics)

    def publish_status(self) -> None:
        """Send the status now; a change of mode or reason is logged once."""
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
            non_finite=said.non_finite,
            invalid=said.invalid,
            status=said.status,
            valid=said.valid,
        )
        self._status.publish(message)

    def _log(self, said: Report) -> None:
        word = f"{said.mode}: {said.reason}" if said.reason else said.mode
        if word == self._word:
            return
        good = said.status in (NodeStatus.STATUS_OK, NodeStatus.STATUS_INITIALIZING)
        (log.info if good else log.warning)(self.node, word)
        self._word = word

    def _publish_diagnostics(self) -> None:
        said = self.report()
        message = DiagnosticArray()
        message.header.stamp = clock.to_stamp(max(clock.now(self.node), 0))
        name = self.node.get_fully_qualified_name()
        message.status = [
            _task(name, "state", _level(said.status), said.reason or said.mode, self._values(said))
        ]
        text = "; ".join(said.problems) or "as expected"
        level = DiagnosticStatus.ERROR if said.problems else DiagnosticStatus.OK
        message.status.append(_task(name, "graph", level, text, {}))
        self._diagnostics.publish(message)

    def _values(self, said: Report) -> dict[str, object]:
        own = {
            "mode": said.mode,
            "output rate [Hz]": f"{self._timing.output_rate:.1f}",
            "step time mean [ms]": f"{1e3 * self._timing.step_time_mean:.3f}",
            "deadline misses": self.meter.deadline_misses,
            "lost inputs": said.stamps.lost,
        }
        return own | dict(said.values)


def _level(status: int) -> bytes:
    if status == NodeStatus.STATUS_OK:
        return DiagnosticStatus.OK
    return DiagnosticStatus.WARN if status in _WARN else DiagnosticStatus.ERROR


def _task(
    node: str, task: str, level: bytes, text: str, values: Mapping[str, object]
) -> DiagnosticStatus:
    pairs = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
    namespace = node.rpartition("/")[0] or "/"
    return DiagnosticStatus(
        level=level, name=f"{node}: {task}", message=text, hardware_id=namespace, values=pairs
    )
