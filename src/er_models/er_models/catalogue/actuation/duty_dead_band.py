"""Dead band of the duty: max(u - u_0, 0)."""

from er_models.effect import Effect, Param, Signature


def duty(u_0: float, u: float) -> float:
    """Duty beyond the dead band [1]."""
    return max(u - u_0, 0.0)


EFFECT = Effect(
    name="duty_dead_band",
    stage="actuation",
    title="Dead band of the duty",
    physics="Below a threshold voltage no chains form, or the amplifier gives no output.",
    parameters=(Param("u_0", "duty", 0.0, 0.6, 0.0, (0.1,), "threshold"),),
    hooks={"duty": duty},
    signature=Signature(
        mark="no yield force at small duty, then proportional",
        plane="force-duty",
        experiment="sine with small duties",
        rivals=("field_exponent",),
        needs=("small_duty", "high_duty"),
    ),
    source="Choi et al. 1998; threshold field of electrorheological fluids",
)
