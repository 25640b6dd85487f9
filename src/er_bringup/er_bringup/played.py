"""A recording played to the core of a node: what it says, and whether the node said the same. No ROS runs.

The order is that of the recording and the time that of its arrivals, so that the same recording gives the
same answers, always and everywhere. Ages are not judged: how old a message was when the node had it, no
recording knows.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush
from pathlib import Path
from time import process_time
from typing import Any

from er_common.common_parameters import STANDSTILL, FramedParameters, deaf_after
from er_common.parameter_table import REQUIRED, build, specs
from er_common.topics import Topic
from er_models.errors import ErError, InputError, MissingChannel
from er_ros_common.builders import tick_of
from er_ros_common.core import Core, Said, When

from er_bringup.cores import entry
from er_bringup.programs import ANSWERING
from er_bringup.recording import Bag

WATCH = 10_000_000
"""How often a core is told that time goes on [ns]."""
ENOUGH = 2
"""So many times the silence after which inputs count as dead: later, a core only says again what it said."""
HELD_UP = 5_000_000_000
"""So much later a message is put in its place, where a recorder that was held up wrote it behind later ones [ns]."""
HEADER = ("header",)

Input = tuple[Topic, Any, int]
"""Topic, message, time of arrival [ns]."""
Key = tuple[int, int, str]
"""Stamp [ns] and sequence number of an answer, and its topic."""


class UnknownParameters(ErError):
    """A recording that lost, or never had, what a node needs to be played."""

    exit_status = 4

    def __init__(self, path: Path, executable: str, missing: Sequence[str]) -> None:
        values = " ".join(f"--set {name}:=..." for name in missing)
        super().__init__(
            f"{path}: the parameters of {executable} are not in the recording: give them, --node {executable} {values}"
        )


def core_of(bag: Bag, executable: str, namespace: str, given: Mapping[str, Any]) -> Core:
    """The core of a node with the parameters it was recorded with, those given on top.

    Raises:
        InputError: A parameter is missing or wrong, a file is gone, the model is another one than was recorded.
        UnknownParameters: No node's parameters are in the recording, nor given.
    """
    shell = entry(executable)
    table = shell.parameters
    full = f"{namespace}/{executable}"
    asked = [spec.name for spec in specs(table) if spec.default is REQUIRED]
    if not bag.parameters and (missing := [name for name in asked if name not in given]):
        raise UnknownParameters(bag.path, executable, missing)
    known = {spec.name for spec in specs(table)}
    recorded = {k: v for k, v in bag.parameters.get(full, {}).items() if k in known}
    origins = dict.fromkeys(recorded, str(bag.path)) | dict.fromkeys(given, "--set")
    core = shell.make(build(table, recorded | dict(given), origins))
    expected, found = bag.models.get(full), core.model_id
    if expected and found and expected != found and "model_file" not in given:
        wanted = (
            f"the model {expected[:12]} that {full} was recorded with (or --set model_file:=...)"
        )
        raise InputError(
            str(recorded.get("model_file", "")), "", wanted, f"the model {found[:12]}"
        )
    return core


@dataclass
class Played:
    """What a core said, and what the node had said.

    same, different: answers to the same sample; only_bag, only_core: samples that only one answered;
    first: where and how they first differ; span: time played [s]; skipped: the rest of long gaps between messages [s];
    took: processor time of playing it [s]; apart: inputs that were recorded apart from the sample of their tick;
    by_tick: whether they were played in the order of the ticks, as the node had them.
    """

    node: str
    answers: list[Said] = field(default_factory=list)
    recorded: int = 0
    same: int = 0
    different: int = 0
    only_bag: int = 0
    only_core: int = 0
    first: str = ""
    span: float = 0.0
    skipped: float = 0.0
    took: float = 0.0
    apart: int = 0
    by_tick: bool = False

    @property
    def compared(self) -> int:
        """Answers to the same sample in recording and replay."""
        return self.same + self.different

    @property
    def speed(self) -> float:
        """Times faster than it was recorded."""
        return self.span / self.took if self.took > 0.0 else 0.0


def play(
    bag: Bag, executable: str, core: Core, namespace: str = "", *, follow: bool = False
) -> Played:
    """Play a recording to a core and compare.

    A recorder that was held up writes messages in the order in which it reads them, the node had them in another:
    where answers differ and the order contradicts the ticks, that of the ticks is tried, too, and taken if it explains
    more of them.

    follow: samples that the recorded node did not answer (it had them too late, or never) are left out.

    Raises:
        MissingChannel: An input that the node needs is not in the recording.
    """
    inputs = {f"{namespace}/{topic.name}": topic for topic in core.inputs}
    for name, topic in inputs.items():
        if topic not in core.optional and name not in bag.topics:
            raise MissingChannel(bag.path, name, f"for {executable}", bag.topics)
    outputs = {f"{namespace}/{topic.name}": topic for topic in core.outputs}
    said_before = _first((topic, m) for topic, m, _ in bag.messages(outputs))
    # the topic of the first input paces the node
    paced = {m.seq for m in said_before.values()} if follow else None
    once = Played(executable, recorded=len(said_before))
    _run(once, bag.messages(inputs), core, paced, said_before)
    if not (once.apart and (once.different or once.only_bag)):
        return once
    again = Played(executable, recorded=len(said_before), by_tick=True)
    _run(again, _by_tick(bag.messages(inputs), core), core, paced, said_before)
    again.apart = once.apart
    return again if again.same > once.same else once


def _run(
    result: Played,
    messages: Iterable[Input],
    core: Core,
    paced: set[int] | None,
    said_before: Mapping[Key, Any],
) -> None:
    """Play messages to the core, and compare."""
    began = process_time()
    result.answers.extend(_steps(messages, core, paced, result))
    result.took = process_time() - began
    _compare(result, said_before)


def _by_tick(messages: Iterable[Input], core: Core) -> Iterator[Input]:
    """The same messages in the order of their ticks, in that of the core's inputs within one."""
    waiting: list[tuple[int, int, int, int, Input]] = []
    run, newest, last = 0, 0, 0
    for count, each in enumerate(messages):
        topic, message, arrival = each
        if topic is core.inputs[0]:
            # a source that was begun anew counts from 1 again
            run, newest = run + (message.seq < newest), message.seq
        heappush(waiting, (run, message.seq, core.inputs.index(topic), count, each))
        while arrival - waiting[0][-1][2] > HELD_UP:
            topic, message, came = heappop(waiting)[-1]
            last = max(last, came)
            yield topic, message, last
    while waiting:
        topic, message, came = heappop(waiting)[-1]
        last = max(last, came)
        yield topic, message, last


def _steps(
    messages: Iterable[Input], core: Core, paced: set[int] | None, result: Played
) -> Iterator[Said]:
    """Everything the core says; result: is told of the time, and of inputs apart from their sample.

    A long gap is silence, or a clock that was set: then the steady clock of the node went on as ever. Played is as
    much of it as can matter.
    """
    state, samples, before, last, newest = core.start(), core.inputs[0], 0, 0, 0
    longest = round(1e9 * ENOUGH * max(STANDSTILL, deaf_after(core.p)))
    for topic, message, arrival in messages:
        if topic is samples:
            newest = message.seq
        elif topic not in core.optional:
            result.apart += message.seq != newest
        before, last = before or arrival, last or arrival
        gap = min(arrival - before, longest)
        result.span += 1e-9 * gap
        result.skipped += 1e-9 * (arrival - before - gap)
        for now in range(last + WATCH, min(arrival, last + longest) + 1, WATCH):
            state, said = core.on_time(state, When(now, None))
            yield from said
        last += max(arrival - last, 0) // WATCH * WATCH
        before = arrival
        if paced is not None and topic is samples and message.seq not in paced:
            continue
        state, said = core.on_message(state, topic, message, When(arrival, None))
        yield from said


def _first(answers: Iterable[Said]) -> dict[Key, Any]:
    """Answers by sample; one may be said once more while samples stay away: that is a matter of time."""
    found: dict[Key, Any] = {}
    for topic, message in answers:
        if _is_answer(message):
            found.setdefault((*tick_of(message), topic.name), message)
    return found


def _compare(result: Played, recorded: Mapping[Key, Any]) -> None:
    """Count what is the same, bit by bit, and find the first difference."""
    answered = _first(result.answers)
    for key in sorted(recorded.keys() | answered.keys()):
        if key not in answered:
            result.only_bag += 1
        elif key not in recorded:
            result.only_core += 1
        else:
            words = difference(recorded[key], answered[key])
            result.same += not words
            result.different += bool(words)
            if words and not result.first:
                result.first = f"seq {key[1]}: {words}"


def difference(recorded: Any, said: Any) -> str:
    """The first field in which two messages differ, but the header; empty where none does."""
    for name in said.get_fields_and_field_types():
        if name in HEADER:
            continue
        before, after = getattr(recorded, name), getattr(said, name)
        if before != after:
            return f"{name} {before!r} recorded, {after!r} replayed"
    return ""


def _is_answer(message: Any) -> bool:
    """Whether it answers a sample; what is said when samples stay away depends on the clock of the moment."""
    return bool(message.status != message.STATUS_LOST)


def assumed(bag: Bag, executable: str, namespace: str, given: Mapping[str, Any]) -> list[str]:
    """Parameters that are taken at their defaults, as those of the node are neither recorded nor given."""
    if f"{namespace}/{executable}" in bag.parameters:
        return []
    common = {spec.name for spec in specs(FramedParameters)}
    names = (spec.name for spec in specs(entry(executable).parameters))
    return [name for name in names if name not in common and name not in given]


def nodes_in(bag: Bag, namespace: str, known: Sequence[str]) -> list[str]:
    """Nodes with a core that were recorded in a namespace; without any parameters those whose answers may be in it."""
    if not bag.parameters:
        each = ((p.name, p.says) for p in ANSWERING)
        said = {
            name for name, topic in each if topic and f"{namespace}/{topic.name}" in bag.topics
        }
        return [name for name in known if name in said]
    return [name for name in known if f"{namespace}/{name}" in bag.parameters]


def namespaces_in(bag: Bag, known: Sequence[str]) -> list[str]:
    """Namespaces in which nodes with a core were recorded."""
    places = (node.rpartition("/") for node in bag.parameters)
    return sorted({space or "/" for space, _, name in places if name in known})
