"""One question to a service of the running graph, from a program that is no part of it."""

from __future__ import annotations

from time import monotonic
from typing import Any

import rclpy
from er_models.errors import ErError
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from er_ros_common import environment

ANSWER = 10.0
"""Longest wait for the service and its answer [s]."""


def asked(kind: Any, service: str, request: Any) -> Any:
    """The answer of a service, by full name; None where nobody answers."""
    environment.settle()
    context = rclpy.Context()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = rclpy.create_node("asks", context=context, enable_rosout=False)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        client = node.create_client(kind, service)
        until, answer = monotonic() + ANSWER, None
        while monotonic() < until and not (answer is not None and answer.done()):
            if answer is None and client.service_is_ready():
                answer = client.call_async(request)
            executor.spin_once(timeout_sec=0.05)
        return answer.result() if answer is not None and answer.done() else None
    finally:
        rclpy.try_shutdown(context=context)


def set_parameters(node: str, **values: Any) -> None:
    """Set parameters of a node, by full name, all of them or none.

    Raises:
        ErError: It refuses, or does not answer.
    """
    each = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
    request = SetParametersAtomically.Request(parameters=each)
    answer = asked(SetParametersAtomically, f"{node}/set_parameters_atomically", request)
    if answer is None or not answer.result.successful:
        raise ErError(f"{node}: {answer.result.reason if answer else 'does not answer'}")
