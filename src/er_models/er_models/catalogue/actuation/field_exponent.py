"""Field law with an exponent: the yield force follows u_r (u / u_r)^b."""

from er_models.effect import Effect, Param, Signature


def duty(b: float, u_r: float, u: float) -> float:
    """Duty that the yield force follows [1]."""
    return u_r * (u / u_r) ** b if u > 0.0 else 0.0


EFFECT = Effect(
    name="field_exponent",
    stage="actuation",
    title="Field exponent",
    physics="Polarisation gives a yield stress as the square of the field, conduction as its "
    "power 1.5, saturation less than 1.",
    parameters=(
        Param("b", "1", 0.2, 3.0, 1.0, (1.3, 0.8), "exponent of the field"),
        Param("u_r", "duty", 0.1, 2.0, None, (1.0,), "duty that is left unchanged", fitted=False),
    ),
    hooks={"duty": duty},
    signature=Signature(
        mark="yield force is not proportional to the duty",
        plane="force-duty",
        experiment="sine at four duties",
        rivals=("duty_dead_band",),
        needs=("duty_levels",),
    ),
    source="thesis (1.5); Davis 1997, polarisation and conduction models",
)
