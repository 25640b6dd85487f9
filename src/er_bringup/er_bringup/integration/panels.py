"""What is plotted together: the one list that all layouts are made from."""

from __future__ import annotations

from typing import NamedTuple

from er_common.topics import Topic
from er_observers.programs import OBSERVERS

from er_common import topics


class Curve(NamedTuple):
    """A field of a topic."""

    topic: Topic
    field: str


class Panel(NamedTuple):
    """Curves with one axis; title with unit."""

    title: str
    curves: tuple[Curve, ...]


class Page(NamedTuple):
    """Panels above one another."""

    title: str
    panels: tuple[Panel, ...]


_FORCES = (topics.FORCE, *map(topics.estimated_force, OBSERVERS))
_FACTORS = ("f1", "f2", "f3")

PAGES = (
    Page(
        "Force and duty",
        (
            Panel("Damper force [N]", tuple(Curve(topic, "force") for topic in _FORCES)),
            Panel(
                "Duty [1]", (Curve(topics.PWM_COMMAND, "duty"), Curve(topics.PWM_APPLIED, "duty"))
            ),
        ),
    ),
    Page(
        "Motion",
        (
            Panel(
                "Acceleration [m/s2]",
                (Curve(topics.ACCELERATION, "sprung"), Curve(topics.ACCELERATION, "unsprung")),
            ),
            Panel(
                "Deflection, road [m]",
                (Curve(topics.DEFLECTION, "deflection"), Curve(topics.ROAD, "displacement")),
            ),
            Panel("Deflection velocity [m/s]", (Curve(topics.DEFLECTION, "velocity"),)),
        ),
    ),
    Page(
        "Model beside the damper",
        (
            Panel(
                "Damper force, measured and of the model [N]",
                (Curve(topics.FORCE, "force"), Curve(topics.MODEL_FORCE, "force")),
            ),
            Panel(
                "Error, its size of late and as it should be [N]",
                (
                    Curve(topics.MODEL_RESIDUAL, "force"),
                    Curve(topics.MODEL_FORCE, "force_sd"),
                    Curve(topics.MODEL_RESIDUAL, "force_sd"),
                ),
            ),
            Panel(
                "Sum of the test, above 1 the model no longer explains",
                (Curve(topics.MODEL_FORCE, "test_ratio"), Curve(topics.MODEL_FORCE, "status")),
            ),
        ),
    ),
    Page(
        "Faults and health",
        (
            Panel("Effectiveness [1]", tuple(Curve(topics.FAULT, name) for name in _FACTORS)),
            Panel(
                "Residual over its gate [1]", tuple(Curve(t, "test_ratio") for t in _FORCES[1:])
            ),
            Panel(
                "Status, 0 is good",
                (
                    Curve(topics.ACCELERATION, "status"),
                    Curve(topics.PWM_APPLIED, "status"),
                    *(Curve(t, "status") for t in _FORCES[1:]),
                    Curve(topics.FAULT, "status"),
                ),
            ),
        ),
    ),
)
"""Measured first, then what is made of it, then whether it can be trusted."""

COLOURS = ("#1f77b4", "#d62728", "#2ca02c", "#ff7f0e", "#9467bd", "#8c564b")
"""Of the curves of a panel, in order."""


def full(namespace: str, topic: Topic) -> str:
    """Name of a topic in a namespace ('' is the root)."""
    inside = namespace.strip("/")
    return f"/{inside}/{topic.name}" if inside else f"/{topic.name}"
