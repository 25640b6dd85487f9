"""Whom the plant waits for, and how long."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from er_models.errors import ErError

pytest.importorskip("rclpy")

from er_plant_sim.nodes import roll_call
from er_plant_sim.nodes.recording import Recording
from er_plant_sim.nodes.roll_call import COMPILING, Gathering, RollCall
from rclpy.exceptions import InvalidTopicNameException

PATIENCE = 20.0


class Graph:
    """Stands for the plant's node: whose status has a publisher, and what is said on it."""

    def __init__(self) -> None:
        self.there: set[str] = set()
        self.heard: dict[str, Callable[[Any], None]] = {}
        self.warned: list[str] = []

    def listen(self, topic: str, kind: type[Any], heard: Callable[[Any], None], _: Any) -> None:
        """Keep who listens."""
        self.heard[topic] = heard

    def resolve_topic_name(self, name: str) -> str:
        """As rclpy's."""
        if " " in name:
            raise InvalidTopicNameException(name, "no spaces", name.index(" "))
        return f"/{name}"

    def count_publishers(self, topic: str) -> int:
        """As rclpy's."""
        return int(topic in self.there)

    def say(self, name: str, mode: str) -> None:
        """A node says how it is."""
        self.there.add(f"{name}/status")
        self.heard[f"{name}/status"](SimpleNamespace(mode=mode))


@pytest.fixture
def graph(monkeypatch: pytest.MonkeyPatch) -> Graph:
    """Nobody is there yet."""
    made = Graph()
    monkeypatch.setattr(roll_call.log, "warning", lambda _, text: made.warned.append(text))
    return made


def after(monkeypatch: pytest.MonkeyPatch, each: Gathering, seconds: float) -> bool:
    """Whether it is complete so long after its beginning."""
    monkeypatch.setattr(roll_call, "monotonic", lambda: each.made_at + seconds)
    return each.complete()


def gathering(graph: Any) -> Gathering:
    """It waits for two observers, and for one subscriber of one topic."""
    out: Any = SimpleNamespace(subscribers=lambda: (1,))
    each = Gathering(graph, out, (1,), ("one", "two"), PATIENCE)
    each.made_at = 1000.0  # a time whose sums are exact
    return each


def test_it_begins_when_everybody_is_ready(graph: Graph, monkeypatch: pytest.MonkeyPatch) -> None:
    each = gathering(graph)
    graph.say("one", "ready")
    graph.say("two", "waiting")
    assert not after(monkeypatch, each, 1.0)
    assert each.missing() == ["two"]
    graph.say("two", "running")
    assert after(monkeypatch, each, 1.0)
    assert graph.warned == []


def test_who_is_not_there_is_waited_for_until_the_patience_ends(
    graph: Graph, monkeypatch: pytest.MonkeyPatch
) -> None:
    each = gathering(graph)
    graph.say("one", "ready")
    assert not after(monkeypatch, each, PATIENCE - 0.1)
    assert after(monkeypatch, each, PATIENCE)
    assert graph.warned == ["starting without two: (1,) of [1] subscribers"]


def test_who_is_there_and_compiles_is_waited_for_longer_but_not_for_ever(
    graph: Graph, monkeypatch: pytest.MonkeyPatch
) -> None:
    each = gathering(graph)
    graph.say("one", "ready")
    graph.there.add("two/status")
    assert each.missing() == ["two (still compiling)"]
    assert not after(monkeypatch, each, 0.9 * COMPILING * PATIENCE)
    assert after(monkeypatch, each, COMPILING * PATIENCE)
    # one that speaks is not compiling any more: it lacks something that may never come
    graph.say("two", "waiting")
    assert not after(monkeypatch, each, PATIENCE - 0.1)
    assert after(monkeypatch, each, PATIENCE)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda g: RollCall(g, ("my node",)), "wait_for_nodes: topic 'my node/status'"),
        (lambda g: Recording(g, "a b", (), 200.0, print), "recorder: topic 'a b/recorded'"),
        (lambda g: Recording(g, "", ("c d",), 200.0, print), "recorded: topic 'c d'"),
    ],
)
def test_a_name_that_no_topic_can_have_is_named_with_its_parameter(
    graph: Graph, make: Callable[[Graph], object], words: str
) -> None:
    with pytest.raises(ErError, match=words):
        make(graph)
