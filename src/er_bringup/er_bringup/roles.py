"""What each kind of node listens to and says: enough to know when everybody has found everybody."""

from __future__ import annotations

from dataclasses import dataclass

from er_common import topic_names

PUBLISHED = {
    "acceleration": topic_names.ACCELERATION,
    "deflection": topic_names.DEFLECTION,
    "force": topic_names.FORCE,
    "road": topic_names.ROAD,
    "applied": topic_names.PWM_APPLIED,
}
"""What the plant publishes, in the order of its parameter `wait_for`."""


@dataclass(frozen=True)
class Role:
    """A kind of node: its program, which keys of `PUBLISHED` it listens to, and its own topic."""

    package: str
    executable: str
    listens: tuple[str, ...]
    says: str = ""


PLANT = Role("er_plant_sim", "plant", ())
BRIDGE = Role("er_plant_sim", "hardware_bridge", ())
SOURCES = (PLANT, BRIDGE)
"""What measures, one of them in a graph; the end of it is the end of all."""
COMPOSED = ("er_bringup", "composed")
"""Package and program that holds several nodes."""
RECORDER = Role("er_model_lab", "recorder", tuple(PUBLISHED))
CONTROLLERS = {
    "ftc": Role(
        "er_ftc_controller",
        "ftc_controller",
        ("acceleration", "deflection"),
        topic_names.PWM_COMMAND,
    ),
    "skyhook": Role(
        "er_ftc_controller",
        "skyhook_controller",
        ("acceleration", "deflection"),
        topic_names.PWM_COMMAND,
    ),
}
OBSERVERS = {
    name: Role(
        "er_observers",
        f"{name}_observer",
        ("acceleration", "applied"),
        topic_names.estimated_force(name),
    )
    for name in topic_names.OBSERVERS
}
FAULTS = Role(
    "er_observers", "fault_estimator", ("acceleration", "deflection", "applied"), topic_names.FAULT
)
