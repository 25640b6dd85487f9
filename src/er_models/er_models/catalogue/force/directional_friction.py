"""Friction that differs by direction: F_e or F_c, times tanh(v / v_0)."""

from math import tanh

from er_models.effect import Effect, Param, Signature


def force(F_e: float, F_c: float, v_0: float, v: float) -> float:
    """Friction force [N]."""
    return (F_e if v > 0.0 else F_c) * tanh(v / v_0)


EFFECT = Effect(
    name="directional_friction",
    stage="force",
    title="Friction that differs by direction",
    physics="The lip of a seal is pressed on by the pressure behind it, and wedges and self-energising brakes grip one "
    "way: the friction has another level in extension than in compression.",
    parameters=(
        Param("F_e", "N", 0.0, 2.0, 0.0, (0.08, 0.02), "sliding friction in extension"),
        Param("F_c", "N", 0.0, 2.0, 0.0, (0.08, 0.02), "sliding friction in compression"),
        Param("v_0", "m/s", 0.002, 0.15, None, (0.02,), "width of the reversal"),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="residual jumps at each reversal from one level to another of unequal size, also at zero duty",
        plane="force-velocity",
        experiment="slow small sine at zero duty, and standstill for the preload",
        rivals=("coulomb_friction", "preload", "stribeck_friction"),
        needs=("slow", "reversals"),
    ),
    source="Armstrong-Helouvry, Dupont and Canudas de Wit 1994 (direction-dependent friction); Tran, Hafizah and "
    "Yanada 2012 (pneumatic cylinders)",
    dissipative=True,
)
