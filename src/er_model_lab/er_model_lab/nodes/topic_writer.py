"""One topic that is recorded: writes what it hears, counts what it lost."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import time_ns

from er_records.recording.bag_writer import BagWriter
from er_records.recording.message_count import Count, count, header_of
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rosbags.interfaces import Connection

from er_common import topics
from er_damper_msgs.msg import NodeStatus
from er_model_lab.nodes.own_messages import own
from er_model_lab.nodes.selection import offers

OURS = "er_damper_msgs/msg/"
Guard = Callable[[Callable[[], None]], None]
"""Runs what writes to disk, and stops the recorder where the disk refuses."""


class Heard:
    """A subscription's messages; the topic enters the recording with the first of them.

    ids: from its last status to the hashes of model and gains, by node; empty for other topics; own: messages of the
    recorder itself; written: what is called with each message of ours that is written.
    """

    written: Callable[[Heard], None] | None = None

    def __init__(
        self, node: Node, bag: BagWriter, guard: Guard, name: str, type_name: str
    ) -> None:
        self.node, self.bag, self.guard = node, bag, guard
        self.name, self.type_name = name, type_name
        self.count, self.own = Count(), 0
        self._is_own = own(node, name, type_name)
        self.ids: dict[str, tuple[str, str]] = {}
        self._topic: Connection | None = None
        self.ours = type_name.startswith(OURS) and type_name != topics.STATUS.type_name

    def on_message(self, data: bytes) -> None:
        """Write one message with the time at which it was received.

        That time is taken here: the events executor of the wheels fails on callbacks that ask for
        the message's info.
        """
        self.guard(partial(self._write, time_ns(), data))
        header = header_of(data) if self.type_name.startswith(OURS) else None
        self.count = count(self.count, header.seq if header else 0)
        if self.written is not None and header:
            self.written(self)
        if self.type_name == topics.STATUS.type_name:
            said = deserialize_message(data, NodeStatus)
            self.ids[said.node or self.name] = (said.model_id, said.gains_id)

    def _write(self, received: int, data: bytes) -> None:
        if self._topic is None:
            self._topic = self._announced()
        self.bag.write(self._topic, received, data)
        self.own += self._is_own(data)

    def _announced(self) -> Connection:
        publishers = self.node.get_publishers_info_by_topic(self.name)
        return self.bag.topic(self.name, self.type_name, offers(publishers))
