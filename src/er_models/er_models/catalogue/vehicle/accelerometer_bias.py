"""Bias of the accelerometers: a_s + b_s and a_us + b_us."""

from er_models.effect import Effect, Param, Signature


def sprung_reading(b_s: float, a_s: float) -> float:
    """Reported acceleration of the body [m/s2]."""
    return a_s + b_s


def unsprung_reading(b_us: float, a_us: float) -> float:
    """Reported acceleration of the wheel [m/s2]."""
    return a_us + b_us


EFFECT = Effect(
    name="accelerometer_bias",
    stage="vehicle",
    title="Bias of the accelerometers",
    physics="The zero of an accelerometer drifts with temperature and mounting angle. Only what the "
    "accelerometers report changes; the car and its damper do not.",
    parameters=(
        Param("b_s", "m/s2", -1.0, 1.0, 0.0, (0.05,), "bias of the body's accelerometer"),
        Param("b_us", "m/s2", -1.0, 1.0, 0.0, (0.05,), "bias of the wheel's accelerometer"),
    ),
    hooks={"sprung_reading": sprung_reading, "unsprung_reading": unsprung_reading},
    signature=Signature(
        mark="the mean of an acceleration over a long record is not zero",
        plane="acceleration-deflection",
        experiment="standstill, or any record long against the lowest frequency",
        rivals=("sprung_mass_error",),
    ),
    source="IEEE Std 1293 (accelerometers); Woodman 2007, An introduction to inertial navigation",
)
