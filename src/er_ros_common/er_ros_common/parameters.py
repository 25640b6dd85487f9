"""Declares a parameter dataclass on a node: checked when it starts, and at every change.

While a lifecycle node is unconfigured everything may change that is not `fixed`; while it is configured what is marked
`dynamic` may, and acts from the next sample on. A node without a lifecycle counts as configured for good.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from typing import Any, TypeVar

from er_common.parameter_table import REQUIRED, Spec, build, check, expectation, param, specs
from er_models.errors import ErError, InputError
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from er_ros_common import log
from er_ros_common.parameter_files import COMMAND_LINE, MISSPELT, dropped, origins, shared, unused
from er_ros_common.private import overrides

__all__ = ["REQUIRED", "declare", "param"]

P = TypeVar("P")
#: parameters that rclpy itself declares on every node
BUILT_IN = ("use_sim_time", "start_type_description_service")
OVERRIDES = "qos_overrides."
"""Begins parameters that change the quality of service of a topic; those of our topics cannot be changed."""
TOPICS_OF_ROS = ("/parameter_events", "/clock", "/rosout")
"""Topics that every node of ROS has: a file for nodes of all kinds may have overrides of theirs."""


def declare(
    node: Node,
    table: type[P],
    on_change: Callable[[P], None] | None = None,
    argv: Sequence[str] | None = None,
) -> P:
    """Declare the table's parameters and return them with what the user gave.

    Args:
        node: the node that owns the parameters.
        table: frozen dataclass whose fields are made with `param`.
        on_change: called with new parameters, checked one by one; what it raises refuses all of them.
        argv: command line that the node was started with; None means the node's, or the process's own.

    Raises:
        InputError: unknown name, wrong type, not finite, out of bounds, or required and not given;
            it names the file (or the command line), the parameter, what was expected and found.
    """
    given = {
        name: parameter.value
        for name, parameter in overrides(node).items()
        if name not in BUILT_IN and not _of_ros(name)
    }
    own = getattr(node, "argv", None) if argv is None else argv
    argv = sys.argv[1:] if own is None else own
    full_name = node.get_fully_qualified_name()
    given |= dropped(argv, given, full_name)
    where = origins(argv, full_name)
    _no_overrides(given, where)
    others = shared(argv, full_name) & _strangers(given, table)
    for name in sorted(others):
        if where[name] == COMMAND_LINE:
            log.info(node, f"{COMMAND_LINE}: {name} is no parameter of this node, left to others")
        del given[name]
    for line in unused(argv, full_name):
        log.info(node, line)
    current = build(table, given, where)
    for spec in specs(table):
        _declare_one(node, spec, getattr(current, spec.attribute))
    _guard(node, table, current, on_change)
    return current


def _strangers(given: Mapping[str, object], table: type[Any]) -> set[str]:
    """Names that are neither a parameter of the table nor nearly one."""
    known = [spec.name for spec in specs(table)]
    return {name for name in given if not get_close_matches(name, known, n=1, cutoff=MISSPELT)}


def _of_ros(name: str) -> bool:
    """Whether a parameter overrides the quality of service of a topic that is not ours."""
    return name.startswith(tuple(f"{OVERRIDES}{topic}." for topic in TOPICS_OF_ROS))


def _no_overrides(given: Mapping[str, object], where: Mapping[str, str]) -> None:
    """Refuse to change the quality of service of a topic of ours: nothing would follow it."""
    for name in given:
        if name.startswith(OVERRIDES):
            expected = "no override: the quality of service of a node's topics is fixed"
            raise InputError(where.get(name, "command line"), name, expected, repr(given[name]))


def _declare_one(node: Node, spec: Spec, value: Any) -> None:
    descriptor = ParameterDescriptor(
        description=f"{spec.text} [{spec.unit}]",
        additional_constraints=expectation(spec),
        read_only=spec.fixed or not (spec.dynamic or hasattr(node, "configured")),
        # rclpy takes the type from the value, and an empty list has none
        dynamic_typing=value == (),
    )
    if spec.kind is float and math.isfinite(spec.high - spec.low):
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=spec.low, to_value=spec.high)
        ]
    if spec.kind is int and math.isfinite(spec.high - spec.low):
        low, high = int(spec.low), int(spec.high)
        descriptor.integer_range = [IntegerRange(from_value=low, to_value=high, step=1)]
    plain = list(value) if isinstance(value, tuple) else value
    node.declare_parameter(spec.name, plain, descriptor, ignore_override=True)


def _guard(node: Node, table: type[P], start: P, on_change: Callable[[P], None] | None) -> None:
    """Check every later change before it takes place, and hand it to the node: ROS asks nobody after this."""
    known = {spec.name: spec for spec in specs(table)}
    current, name = [start], node.get_fully_qualified_name()

    def before(parameters: list[Parameter]) -> SetParametersResult:
        settled = getattr(node, "configured", True)
        ours = [(known[p.name], p.value) for p in parameters if p.name in known]
        try:
            for spec, _ in ours:
                if settled and not spec.dynamic:
                    expected = "no change while the node is configured (ros2 lifecycle set: deactivate, cleanup)"
                    raise InputError(name, spec.name, expected, "one")
            changed = {spec.attribute: check(spec, value, name) for spec, value in ours}
            new: Any = replace(current[0], **changed)  # type: ignore[type-var]
            if changed and on_change is not None:
                on_change(new)
        except ErError as error:
            return SetParametersResult(successful=False, reason=str(error))
        current[0] = new
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(before)
