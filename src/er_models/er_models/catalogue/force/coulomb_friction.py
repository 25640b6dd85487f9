"""Coulomb friction of seals and rod guide: F_c tanh(v / v_0)."""

from math import tanh

from er_models.effect import Effect, Param, Signature


def force(F_c: float, v_0: float, v: float) -> float:
    """Friction force [N]."""
    return F_c * tanh(v / v_0)


EFFECT = Effect(
    name="coulomb_friction",
    stage="force",
    title="Coulomb friction",
    physics="Seals and rod guide rub with a force that only knows the direction of the "
    "motion, with or without field.",
    parameters=(
        Param("F_c", "N", 0.0, 2.0, 0.0, (0.05,), "sliding friction"),
        Param("v_0", "m/s", 0.002, 0.15, None, (0.02,), "width of the reversal"),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="residual jumps with the sign of the velocity, also at zero duty",
        plane="force-velocity",
        experiment="fast small sine at zero duty",
        rivals=("stribeck_friction", "shear_thinning", "bouc_wen_hysteresis"),
        needs=("slow", "reversals"),
    ),
    source="Amontons-Coulomb, smooth form; Armstrong-Helouvry, Dupont and Canudas de Wit 1994",
    dissipative=True,
)
