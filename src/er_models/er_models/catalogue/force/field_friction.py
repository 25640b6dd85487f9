"""Friction that grows with the field: F_u u_f tanh(v / v_0), without the lag of the yield force at reversals."""

from math import tanh

from er_models.effect import Effect, Param, Signature


def force(F_u: float, v_0: float, u_f: float, v: float) -> float:
    """Friction force [N]."""
    return F_u * u_f * tanh(v / v_0)


EFFECT = Effect(
    name="field_friction",
    stage="force",
    title="Friction that grows with the field",
    physics="What the duty commands presses surfaces on one another: the shoes of a brake, a seal under pressure, a "
    "sponge full of fluid. The friction is in proportion to it and turns with the velocity at once, while chains "
    "would take their time to form anew.",
    parameters=(
        Param("F_u", "N/duty", 0.0, 10.0, 0.0, (0.1,), "sliding friction per duty"),
        Param("v_0", "m/s", 0.002, 0.15, None, (0.02,), "width of the reversal"),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="residual jumps with the sign of the velocity, higher the higher the duty",
        plane="force-velocity",
        experiment="slow sine of small stroke at several duties, zero among them",
        rivals=("coulomb_friction", "herschel_bulkley", "bouc_wen_hysteresis"),
        needs=("slow", "reversals", "duty_levels"),
    ),
    source="Tran, Hafizah and Yanada 2012 (friction of pneumatic cylinders grows with the pressure); Chrzan and "
    "Carlson 2001 (MR sponge dampers)",
    dissipative=True,
)
