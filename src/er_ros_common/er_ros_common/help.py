"""``--help`` of a node, printed from the same tables that make its topics and parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from er_common.parameter_table import REQUIRED, Spec, expectation, specs
from er_common.program import Program
from er_common.topics import Topic


@dataclass(frozen=True, slots=True)
class Card:
    """What there is to know about a node from outside.

    Attributes:
        parameters: dataclass made with `param`, None where the node has none.
        subscribes, publishes: topics, in the order of the help.
        more: paragraphs below the program's own text.
    """

    program: Program
    parameters: type[Any] | None = None
    subscribes: tuple[Topic, ...] = ()
    publishes: tuple[Topic, ...] = ()
    more: tuple[str, ...] = ()


def render(card: Card) -> str:
    """The help text."""
    options = "[--ros-args -p NAME:=VALUE --params-file FILE -r OLD:=NEW]"
    usage = f"{card.program.package} {card.program.name} {options}"
    parts = [card.program.text, *card.more, f"usage: ./er run {usage}\n       ros2 run {usage}"]
    parts.append(_section("subscribes to", [_topic_row(t) for t in card.subscribes]))
    parts.append(_section("publishes", [_topic_row(t) for t in card.publishes]))
    rows = [_parameter_row(s) for s in specs(card.parameters)] if card.parameters else []
    parts.append(
        _section(
            "parameters (change while it is unconfigured; dynamic: at any time; fixed: never)",
            rows,
        )
    )
    return "\n\n".join(part for part in parts if part)


def _section(title: str, rows: list[tuple[str, ...]]) -> str:
    if not rows:
        return ""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]) - 1)]
    lines = [
        "  ".join([*(c.ljust(w) for c, w in zip(row, widths, strict=False)), row[-1]])
        for row in rows
    ]
    return "\n".join([f"{title}:", *(f"  {line}" for line in lines)])


def _topic_row(topic: Topic) -> tuple[str, ...]:
    return (topic.name, topic.type_name, f"{topic.rate:g} Hz", topic.text)


def _parameter_row(spec: Spec) -> tuple[str, ...]:
    default = "required" if spec.default is REQUIRED else f"default {_shown(spec.default)}"
    return (
        spec.name,
        expectation(spec),
        default,
        spec.text + (", dynamic" if spec.dynamic else ", fixed" if spec.fixed else ""),
    )


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(_shown(entry) for entry in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else repr(value)
