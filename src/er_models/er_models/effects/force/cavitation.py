"""Cavitation: the rebound force cannot exceed F_v."""

from er_models.effect import Effect, Param, Signature


def limit(F_v: float, f_d: float) -> float:
    """Force after cavitation [N]: the pressure in the low chamber cannot fall below vapour pressure."""
    return min(f_d, F_v)


EFFECT = Effect(
    name="cavitation",
    stage="force",
    title="Cavitation",
    physics="Fast extension draws the pressure in one chamber to vapour pressure; the force "
    "cannot grow further.",
    parameters=(
        Param("F_v", "N", 0.05, 1e6, float("inf"), (0.7, 0.4), "force where the fluid cavitates"),
    ),
    hooks={"limit": limit},
    signature=Signature(
        mark="force is cut off on one side",
        plane="force-velocity",
        experiment="fast large sine at high duty",
        rivals=("asymmetric_damping",),
    ),
    source="Dixon 2007, ch. 5; Duym 2000",
)
