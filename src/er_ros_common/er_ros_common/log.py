"""Lines in a node's log. Each severity has its own place in the code, which rclpy asks for."""

from __future__ import annotations

from rclpy.node import Node


def info(node: Node, text: str) -> None:
    """Something worth knowing."""
    node.get_logger().info(text)


def warning(node: Node, text: str) -> None:
    """Something that still works but needs attention."""
    node.get_logger().warning(text)
