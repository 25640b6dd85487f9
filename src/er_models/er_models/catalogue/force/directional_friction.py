"""Friction differs by direction: F_a |tanh(v / v_0)|, beside what both directions have in common."""

from math import tanh

from er_models.effect import Effect, Param, Signature


def force(F_a: float, v_0: float, v: float) -> float:
    """Even part of the friction force [N]."""
    return F_a * abs(tanh(v / v_0))


EFFECT = Effect(
    name="directional_friction",
    stage="force",
    title="Friction that differs by direction",
    physics="The lip of a seal is pressed on by the pressure behind it, and wedges and self-energising brakes grip one "
    "way: with Coulomb friction F_c the level is F_c + F_a in extension and F_c - F_a in compression. Unlike a "
    "preload it vanishes at standstill.",
    parameters=(
        Param(
            "F_a",
            "N",
            -2.0,
            2.0,
            0.0,
            (0.05,),
            "half the difference of friction, extension minus compression",
        ),
        Param("v_0", "m/s", 0.02, 0.3, None, (0.04,), "width of the reversal"),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="residual of one sign in motion, gone at each reversal and at standstill",
        plane="force-velocity",
        experiment="slow small sine at zero duty, with standstills between",
        rivals=("preload", "asymmetric_damping", "coulomb_friction"),
        needs=("slow", "reversals"),
    ),
    source="Armstrong-Helouvry, Dupont and Canudas de Wit 1994 (direction-dependent friction); Tran, Hafizah and "
    "Yanada 2012 (pneumatic cylinders)",
)
