"""Preload: a constant force."""

from er_models.effect import Effect, Param, Signature


def force(F_0: float) -> float:
    """Constant force [N]."""
    return F_0


EFFECT = Effect(
    name="preload",
    stage="force",
    title="Preload or force bias",
    physics="Gas pressure on the rod area pushes the rod out with a constant force. A bias of "
    "the force sensor looks the same: only a run with the damper removed tells them "
    "apart.",
    parameters=(Param("F_0", "N", -2.0, 2.0, 0.0, (0.05,), "constant force"),),
    hooks={"force": force},
    signature=Signature(
        mark="residual with a mean, the same everywhere",
        plane="time",
        experiment="standstill in the middle of the stroke",
        rivals=("deflection_zero",),
        needs=(),
    ),
    source="thesis (1.2), term P_a A_s; Dixon 2007",
)
