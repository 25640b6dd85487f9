"""Kinds of dampers that a start model can be of."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Kind:
    """A kind of damper: the effects that its start model is made of, and what it is."""

    effects: tuple[str, ...]
    title: str


KINDS: dict[str, Kind] = {
    "er": Kind(("passive", "guo_yield", "response"), "electrorheological: a yield force that follows the duty"),
    "mr": Kind(
        ("passive", "guo_yield", "response", "coulomb_friction"),
        "magnetorheological: the same beside a friction that remains without a field",
    ),
    "passive": Kind(("passive_by_direction",), "no field: damping in rebound and compression"),
    "friction": Kind(("passive", "coulomb_friction"), "a seal, a guide, a brake, a drive"),
}  # fmt: skip
"""What `lab new --kind` offers: the only list."""
