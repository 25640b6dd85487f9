"""Coulomb friction of seals and rod guide: F_c tanh(v / v_0) where r is 0.

Rubber gives before it slides, and the friction rises slowly: F_c (2 / pi) arctan(v / v_0) at 1.
"""

from math import atan, pi, tanh

from er_models.effect import Effect, Param, Signature


def force(F_c: float, v_0: float, r: float, v: float) -> float:
    """Friction force [N]."""
    sharp = tanh(v / v_0)
    slow = r * (2.0 / pi * atan(v / v_0) - sharp) if r != 0.0 else 0.0
    return F_c * (sharp + slow)


EFFECT = Effect(
    name="coulomb_friction",
    stage="force",
    title="Coulomb friction",
    physics="Seals and rod guide rub with a force that only knows the direction of the "
    "motion, with or without field.",
    parameters=(
        Param("F_c", "N", 0.0, 2.0, 0.0, (0.05,), "sliding friction"),
        Param("v_0", "m/s", 0.002, 0.15, None, (0.02,), "width of the reversal"),
        Param("r", "1", 0.0, 1.0, 0.0, (0.0, 0.5), "how slowly it rises", optional=True),
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
