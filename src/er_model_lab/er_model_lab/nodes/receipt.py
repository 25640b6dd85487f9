"""What is written so far, said to whoever waits for it: a plant in lockstep."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from er_ros_common.managed import ManagedNode

from er_common import topics
from er_model_lab.nodes.topic_writer import Heard

STEP = 8
"""Messages of a topic after which it is said anew."""


class Receipt:
    """Says the number of the last message of each topic that is written, while somebody listens."""

    def __init__(self, node: ManagedNode) -> None:
        self.out = node.advertise(topics.RECORDED)
        self.heard: list[Heard] = []
        self.said: dict[str, int] = {}
        self.asked = False

    def of(self, heard: Heard) -> Heard:
        """Take in a topic that is going to be recorded."""
        if heard.ours:
            self.heard.append(heard)
            heard.written = self.note
        return heard

    def note(self, heard: Heard) -> None:
        """A message is written."""
        if self.asked and abs(heard.count.last - self.said.get(heard.name, 0)) >= STEP:
            self.say()

    def look(self) -> None:
        """Say what has not been said yet; now and then."""
        self.asked = self.out.get_subscription_count() > 0
        if self.asked and self.said != self.written():
            self.say()

    def written(self) -> dict[str, int]:
        """Number of the last message of each topic, 0 before the first."""
        return {each.name: each.count.last for each in self.heard}

    def say(self) -> None:
        """Say it."""
        self.said = self.written()
        values = [KeyValue(key=name, value=str(last)) for name, last in self.said.items()]
        self.out.publish(DiagnosticStatus(name="recorded", values=values))
