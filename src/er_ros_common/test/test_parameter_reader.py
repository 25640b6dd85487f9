"""Parameters of other nodes: whatever those answer, nothing is raised."""

from __future__ import annotations

import json
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rclpy")

from er_ros_common.parameter_reader import ParameterReader
from rcl_interfaces.msg import ParameterValue
from rclpy.task import Future

from er_ros_common import parameter_reader

Answer = Callable[[list[str]], Any]
BYTES = ParameterValue(type=5, byte_array_value=[b"\x01", b"\xff"])
NUMBER = ParameterValue(type=3, double_value=1.5)


class Other:
    """A reader's node, and the only other one of its graph: answers with these names and values."""

    def __init__(self, names: list[str], values: Answer) -> None:
        self.names, self.values, self.asked = names, values, 0

    def get_fully_qualified_name(self) -> str:
        return "/reader"

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        return [("reader", "/"), ("other", "/")]

    def create_client(self, _: Any, name: str) -> Any:
        ask = self._list if name.endswith("list_parameters") else self._get
        return SimpleNamespace(service_is_ready=lambda: True, call_async=ask)

    def _list(self, _: Any) -> Future:
        return answered(SimpleNamespace(result=SimpleNamespace(names=self.names)))

    def _get(self, request: Any) -> Future:
        self.asked += 1
        return answered(self.values(list(request.names)))


def answered(answer: Any) -> Future:
    """A future that is over; an exception is raised by its result, None never comes."""
    future = Future()
    if isinstance(answer, Exception):
        future.set_exception(answer)
    elif answer is not None:
        future.set_result(answer)
    return future


def rclpy_answer(names: list[str]) -> Any:
    """What a node of rclpy answers: nothing at all where one of those asked for has no value."""
    return SimpleNamespace(values=[] if "unset" in names else [NUMBER] * len(names))


def found(names: list[str], values: Answer) -> tuple[dict[str, Any], Other]:
    """What a reader finds out of the other node, and that node."""
    other: Any = Other(names, values)
    reader = ParameterReader(other, lambda _: True)
    reader.look()
    return reader.found, other


def test_a_parameter_without_a_value_hides_no_other() -> None:
    names = ["a", "b", "unset", "c", "qos_overrides.x"]
    assert found(names, rclpy_answer)[0] == {"/other": dict.fromkeys("abc", 1.5)}
    assert found(["unset"], rclpy_answer)[0] == {"/other": {}}


def test_values_are_what_json_knows() -> None:
    answers = [BYTES, ParameterValue(type=99), ParameterValue()]
    values, _ = found(["bytes", "odd", "none"], lambda _: SimpleNamespace(values=answers))
    assert values == {"/other": {"bytes": [1, 255], "odd": None, "none": None}}
    json.dumps(values)


@pytest.mark.parametrize("answer", [ValueError("cannot be\ndecoded"), SimpleNamespace(values=7)])
def test_nonsense_is_said_in_one_line(monkeypatch: pytest.MonkeyPatch, answer: Any) -> None:
    lines: list[str] = []
    monkeypatch.setattr(parameter_reader.log, "warning", lambda _, text: lines.append(text))
    assert found(["a"], lambda _: answer)[0] == {}
    assert len(lines) == 1
    assert lines[0].startswith("parameters of /other cannot be read: ")
    assert "\n" not in lines[0]


def test_a_service_that_never_answers_is_asked_again_and_given_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr(parameter_reader, "monotonic", lambda: clock.now)
    other: Any = Other(["a"], lambda _: None)
    reader = ParameterReader(other, lambda _: True)
    for clock.now in (100.0, 100.5, 101.5, 200.0, 300.0):
        reader.look()
    assert (other.asked, reader.found) == (2, {})
