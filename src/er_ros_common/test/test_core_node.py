"""What the node around a core does for it, without ROS running."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rclpy")

from er_common.topics import FAULT, PWM_COMMAND, Topic
from er_ros_common.core import Core, Said, Shell, When
from er_ros_common.core_node import CoreNode
from er_ros_common.health import Report

WORDS = Topic("~/words", "std_msgs/msg/String", "what it was made with", 0.0)


def saying(content: Any) -> Any:
    """A message of the core."""
    return SimpleNamespace(content=content, header=SimpleNamespace(frame_id=""))


class Counting(Core):
    """Says the number of its messages; an even one is urgent."""

    def __init__(self, p: Any) -> None:
        self.p, self.inputs, self.limits, self.outputs = p, (), (), (PWM_COMMAND,)

    def start(self) -> int:
        return 0

    def on_message(self, state: int, _topic: Any, message: int, _: When) -> tuple[int, list[Said]]:
        return state + 1, [(PWM_COMMAND, saying(state + 1))] if message else []

    def urgent(self, before: int, after: int) -> bool:
        assert after == before + 1
        return after % 2 == 0

    def report(self, state: int) -> Report:
        return Report("running" if state else "", reason="that of the core", invalid=state)

    def notes(self) -> list[Said]:
        return [(WORDS, self.p.words)]

    def last_words(self, state: int, when: When) -> list[Said]:
        return [(PWM_COMMAND, saying((state, when)))]


@pytest.fixture
def node() -> Any:
    """A node whose ends keep what is published there."""
    node = CoreNode.__new__(CoreNode)
    published: dict[str, list[Any]] = {}

    def advertise(topic: Topic) -> Any:
        return SimpleNamespace(publish=published.setdefault(topic.name, []).append)

    said: list[str] = []
    health = SimpleNamespace(
        meter=SimpleNamespace(step=lambda _: said.append("step"), deadline=0.0),
        publish_status=lambda: said.append("status"), model_id="", gains_id="",
    )  # fmt: skip
    p = SimpleNamespace(
        words="made", timeout=0.05, max_age=0.02, pace=0.0, listeners=0, frame_id="strut"
    )
    watches: list[tuple[Any, ...]] = []
    more = {
        "p": p, "shell": Shell(object, Counting, (), (), period=0.02, patience=0.03), "health": health,
        "advertise": advertise, "published": published, "said": said, "came": When(1, None),
        "watch_every": lambda *given: watches.append(given), "watches": watches, "when": lambda: When(9, None),
    }  # fmt: skip
    for name, value in more.items():
        object.__setattr__(node, name, value)
    node.configure()
    node.begin()
    return node


def test_what_a_core_says_is_published_and_what_is_urgent_is_said_at_once(node: Any) -> None:
    for message in (1, 1, 0, 0):
        node.on_message(FAULT, message)
    said = node.published[PWM_COMMAND.name]
    assert [each.content for each in said] == [1, 2]
    assert [each.header.frame_id for each in said] == ["strut", "strut"]
    assert node.said == ["step", "status", "step"]
    assert node.state == 4


def test_notes_are_said_once_and_nobody_waits_for_who_reads_them(node: Any) -> None:
    assert node.published[WORDS.name] == ["made"]
    assert node.ends.keys() == {PWM_COMMAND.name}


def test_a_core_that_has_heard_nothing_leaves_the_word_to_the_node(
    node: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(CoreNode, "before_samples", lambda _: ("waiting", "for somebody"))
    first = node.report()
    assert (first.mode, first.reason) == ("waiting", "for somebody")
    node.on_message(FAULT, 1)
    assert node.report() == Report("running", reason="that of the core", invalid=1)


def test_the_last_words_are_published(node: Any) -> None:
    node.on_message(FAULT, 0)
    node.end()
    (last,) = node.published[PWM_COMMAND.name]
    assert (last.content, last.header.frame_id) == ((1, When(9, None)), "strut")


def test_silence_is_looked_at_as_the_shell_says(node: Any) -> None:
    ((period, due, patience),) = node.watches
    assert (period, patience) == (0.02, 0.03)
    assert due == node.on_watch
