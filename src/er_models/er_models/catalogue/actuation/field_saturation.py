"""Saturation of the field: u / (1 + s u) (Froehlich and Kennelly)."""

from er_models.effect import Effect, Param, Signature


def duty(s: float, u: float) -> float:
    """Duty that the yield force follows [1]."""
    return u / (1.0 + s * u) if u > 0.0 else u


EFFECT = Effect(
    name="field_saturation",
    stage="actuation",
    title="Saturation of the field",
    physics="Particles and iron saturate, or the source droops under load: each further step of "
    "the duty adds less field.",
    parameters=(Param("s", "1/duty", 0.0, 20.0, 0.0, (1.0,), "inverse of the duty that halves"),),
    hooks={"duty": duty},
    signature=Signature(
        mark="yield force bends towards a plateau at high duty",
        plane="force-duty",
        experiment="sine at five duties up to the highest",
        rivals=("field_exponent", "duty_dead_band"),
        needs=("duty_levels", "high_duty"),
    ),
    source="Froehlich 1881, Kennelly 1891, law of magnetisation; Ginder and Davis 1994, role of "
    "magnetic saturation",
)
