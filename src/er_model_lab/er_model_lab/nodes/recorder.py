"""The recorder node: writes the graph's topics into a rosbag2 recording and counts what was lost.

Messages are stored as they came, undecoded. The recording also holds, as custom data: the hashes
of models and gains, the parameters of all nodes, versions, and for each topic what was received
and lost.
"""

from __future__ import annotations

import shutil
import signal
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from time import monotonic

from er_common.common_parameters import NodeParameters
from er_common.versions import versions
from er_models.errors import ErError, MissingChannel
from er_records.recording.bag_writer import STORAGES, BagWriter
from er_records.recording.message_count import Count
from er_records.recording.message_definitions import full_definition
from er_ros_common.graph_check import compatible, connected, offered
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.managed import ManagedNode
from er_ros_common.parameter_reader import ParameterReader
from er_ros_common.parameters import REQUIRED, declare, param
from er_ros_common.spin import Executable, run
from er_ros_common.stopping import on_leaving
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from er_common import quality, topics
from er_damper_msgs.msg import NodeStatus
from er_model_lab.nodes.receipt import Receipt
from er_model_lab.nodes.selection import KNOWN, Selection, message_class
from er_model_lab.nodes.topic_writer import Heard
from er_model_lab.programs import RECORDER
from er_ros_common import log

SCHEMA = "er_bag 1"
LOOK_PERIOD, FLUSH_PERIOD = 0.1, 1.0
DEADLINE = 0.05
"""Longest step: what waits meanwhile fits into the queue [s]."""
DISK_FULL = 1
RECENT = 5.0
"""Time for which a loss shows in the status [s]; the recording keeps the count."""


@dataclass(frozen=True, kw_only=True)
class RecorderParameters(NodeParameters):
    """Parameters of the node."""

    out: str = param(REQUIRED, text="folder to be made for the recording")
    storage: str = param("mcap", choices=tuple(STORAGES), text="format of the recording")
    topics: tuple[str, ...] = param((), text="topics to record; none: those of the contract")
    all: bool = param(False, text="record every topic of the graph")
    sources: tuple[str, ...] = param((), text="topics whose publishers to find before it is ready")
    names: tuple[str, ...] = param(
        (), text="topics with other names, USUAL=OTHER in full: readers find them by this note"
    )
    duration: float = param(
        0.0, unit="s", low=0.0, high=1e6, text="stop after this time; 0: when told to"
    )


class Recorder(ManagedNode):
    """Subscribes to what it is to record as soon as it appears."""

    def __init__(self, argv: Sequence[str] | None = None) -> None:
        super().__init__(RECORDER.name, argv)
        self.p = declare(self, RecorderParameters, self.changed)
        self.trouble: ErError | None = None

    def configure(self) -> None:
        """Open the recording, the only one of this process."""
        if hasattr(self, "bag"):
            raise ErError("a recorder makes one recording: start another one for the next")
        # names are looked at before the folder is made: a wrong one must not leave it behind
        self.selection = Selection(self, self.p.topics, self.p.sources, everything=self.p.all)
        self.sources = [self.selection.full(name) for name in self.p.sources]
        out = Path(self.p.out)
        if not out.exists():
            on_leaving(self._left)
        self.bag = BagWriter(out, self.p.storage)
        self.parameters = ParameterReader(self, self._inside)
        self.taken: dict[str, str] = {}
        self.heard: dict[str, Heard] = {}
        self.receipt = Receipt(self)
        self.inputs: dict[str, Subscription] = {}
        self.refused: list[str] = []
        self.lost, self.lost_at, self.was_ready = 0, 0.0, False
        self.health.meter.deadline = DEADLINE
        self.every(LOOK_PERIOD, self.on_look)
        self.every(FLUSH_PERIOD, self.on_flush)

    def begin(self) -> None:
        """Subscribe to what is there."""
        self.began, self.stopping = monotonic(), False
        self.subscribe_new()

    def _inside(self, full: str) -> bool:
        return self.p.all or full.startswith(f"{self.selection.namespace}/")

    def _left(self) -> None:
        """Keep nothing: a signal came while the recording was made, before anything could be heard."""
        shutil.rmtree(self.p.out)
        sys.stderr.write(f"{RECORDER.name}: {self.p.out}: nothing was recorded, it is not kept\n")

    def subscribe_new(self) -> None:
        """Subscribe to what appeared."""
        for name, type_name in self.selection.offered().items():
            if name not in self.taken:
                self.take(name, type_name)

    def on_look(self) -> None:
        """Subscribe to what appeared; stop when the time is over."""
        self.subscribe_new()
        self.ask_for_less()
        self.receipt.look()
        if self.p.duration and monotonic() - self.began > self.p.duration and not self.stopping:
            self.stop()

    def take(self, name: str, type_name: str) -> None:
        """Subscribe to one topic, unless nobody publishes it yet and nothing is known about it."""
        publishers = self.get_publishers_info_by_topic(name)
        if not publishers and name not in self.selection.types:
            return
        self.taken[name] = type_name
        if message_class(type_name) is None or not self.defined(type_name):
            self.problem(f"{name} is not recorded: there is no definition of {type_name}")
            return
        asked = compatible(publishers, quality.RECORDER.depth)
        self.heard[name] = self.receipt.of(Heard(self, self.bag, self.guarded, name, type_name))
        self.inputs[name] = self.end_of(name, asked)

    def end_of(self, name: str, asked: QoSProfile) -> Subscription:
        """A subscription of a topic that is heard as long as it is the last one of it."""
        heard = self.heard[name].on_message

        def told(data: bytes) -> None:
            if self.inputs[name] is made:
                heard(data)

        kind = message_class(self.taken[name])
        made = self.create_subscription(kind, name, self.while_active(told), asked, raw=True)
        return made

    def ask_for_less(self) -> None:
        """Subscribe anew where somebody came who does not offer what was asked for before.

        The end before stays, unheard: destroying one under the events executor is not safe.
        """
        for name, taken in list(self.inputs.items()):
            if self.count_publishers(name) <= taken.get_publisher_count():
                continue
            there = self.get_publishers_info_by_topic(name)
            right = [info for info in there if info.topic_type == self.taken[name]]
            if not offered(taken.qos_profile, right):
                log.info(self, f"{name}: asking for less, to hear everybody who publishes it")
                self.inputs[name] = self.end_of(name, compatible(right, quality.RECORDER.depth))

    def defined(self, type_name: str) -> bool:
        """Whether a type's definition is found; found now, its first message holds up no other."""
        try:
            full_definition(type_name)
        except ErError:
            return False
        return True

    def problem(self, text: str) -> None:
        """Say once what is wrong and keep it for the report."""
        if text not in self.refused:
            self.refused.append(text)
            log.warning(self, text)

    def on_flush(self) -> None:
        """Bring the recording to disk, and look for nodes and wrong types."""
        self.guarded(self.bag.flush)
        self.parameters.look()
        for name, kinds in self.get_topic_names_and_types():
            other = [kind for kind in kinds if kind != self.taken.get(name, kind)]
            if other:
                self.problem(f"{name} also has type {', '.join(other)}: those are not recorded")

    def guarded(self, action: Callable[[], None]) -> None:
        """Write; where the disk refuses, stop with one line instead of a traceback."""
        if self.trouble is not None:
            return
        try:
            action()
        except OSError as error:
            self.trouble = self._unwritable(error)
            self.stop()

    def _unwritable(self, error: OSError) -> ErError:
        return ErError(f"{self.p.out}: cannot be written: {error.strerror}")

    @property
    def counts(self) -> dict[str, Count]:
        """What was received and lost, of every topic that carried anything."""
        return {name: each.count for name, each in self.heard.items() if each.count.received}

    @property
    def gaps(self) -> dict[str, int]:
        """Messages lost, of topics that lost any; not of a status: the newest has replaced it on purpose."""
        each = {name: heard.count.lost for name, heard in self.heard.items() if heard.ours}
        return {name: lost for name, lost in each.items() if lost}

    def ready(self) -> bool:
        """Whether every topic it was told of has a publisher that it hears."""
        if any(name not in self.inputs for name in self.sources):
            return False
        return connected([self.inputs[name] for name in self.sources])

    def stop(self) -> None:
        """End the node as Ctrl-C would."""
        self.stopping = True
        signal.raise_signal(signal.SIGINT)

    def report(self) -> Report:
        """Health of the recorder."""
        lost = sum(self.gaps.values())
        if lost > self.lost:
            self.lost, self.lost_at = lost, monotonic()
        fresh = self.lost > 0 and monotonic() - self.lost_at < RECENT
        values = {"messages": self.bag.messages, "topics": len(self.counts), "lost": lost}
        status = NodeStatus.STATUS_DEGRADED if fresh else NodeStatus.STATUS_OK
        reason = f"{lost} messages lost so far" if fresh else ""
        self.was_ready = self.was_ready or self.ready()
        mode = "recording" if self.was_ready else "waiting"
        return Report(mode, status, reason, values=values, problems=tuple(self.refused))

    def close(self) -> None:
        """Close the recording with what is known about it; one without messages of others is not kept."""
        own = sum(heard.own for heard in self.heard.values())
        if self.bag.messages <= own:
            self.bag.discard(own)
            wanted = ", ".join(self.selection.types or self.selection.names or ("any topic",))
            self.trouble = self.trouble or MissingChannel(
                self.p.out, wanted, "to record anything", tuple(self.counts)
            )
            return
        try:
            self.bag.close(self.custom())
        except OSError as error:
            self.trouble = self.trouble or self._unwritable(error)
        if self.trouble:
            return
        words = ", ".join(f"{name} {n}" for name, n in sorted(self.gaps.items())) or "nothing"
        written = f"{self.bag.messages} messages of {len(self.counts)} topics"
        log.info(self, f"{self.p.out}: {written}, lost {words}")

    def custom(self) -> dict[str, object]:
        """What is known about the whole recording."""
        own = {key: value for key, value in asdict(self.p).items() if key != "out"}
        everybody = self.parameters.found | {self.get_fully_qualified_name(): own}
        ids = {node: each for heard in self.heard.values() for node, each in heard.ids.items()}
        return {
            "schema": SCHEMA,
            "names": dict(name.partition("=")[::2] for name in self.p.names),
            "models": {node: model for node, (model, _) in ids.items() if model},
            "gains": {node: gains for node, (_, gains) in ids.items() if gains},
            "parameters": everybody,
            "versions": versions(),
            "messages": {
                name: {k: v for k, v in c._asdict().items() if k != "last"}
                for name, c in self.counts.items()
            },
            "problems": self.refused,
        }


CARD = Card(
    RECORDER,
    RecorderParameters,
    subscribes=(*KNOWN, topics.STATUS, topics.DIAGNOSTICS),
    publishes=(topics.RECORDED, topics.STATUS),
)


NODE = Executable(Recorder, CARD)


def record(args: Sequence[str] | None = None) -> int:
    """Run the recorder with these arguments; returns the exit status."""
    made: list[Recorder] = []

    def factory() -> Recorder:
        made.append(Recorder())
        return made[0]

    # a terminal that is closed ends the recording as properly as Ctrl-C does
    signal.signal(signal.SIGHUP, lambda *_: signal.raise_signal(signal.SIGTERM))
    status = run(factory, CARD, args)
    failure = made[0].trouble if made else None
    if status == 0 and failure is not None:
        sys.stderr.write(f"{RECORDER.name}: {failure}\n")
        return failure.exit_status if isinstance(failure, MissingChannel) else DISK_FULL
    return status


def main() -> None:
    """Entry point of the executable."""
    status = record()
    # the wish to stop may arrive again while the interpreter is taken down
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    sys.exit(status)


if __name__ == "__main__":
    main()
