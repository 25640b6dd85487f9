"""Rebound and compression differ: c_a |v|."""

from er_models.effect import Effect, Param, Signature


def force(c_a: float, v: float) -> float:
    """Even part of the damping force [N]."""
    return c_a * abs(v)


EFFECT = Effect(
    name="asymmetric_damping",
    stage="force",
    title="Rebound-compression asymmetry",
    physics="Valves open differently in the two directions: damping c_0 + c_a in extension, "
    "c_0 - c_a in compression.",
    parameters=(
        Param(
            "c_a",
            "N s/m",
            -5.0,
            5.0,
            0.0,
            (0.1, -0.1),
            "half the difference of damping, extension minus compression",
        ),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="residual is even in velocity: a V in force-velocity",
        plane="force-velocity",
        experiment="fast sine at zero duty",
        rivals=("gas_spring", "cavitation"),
    ),
    source="thesis Table 1.3; Dixon 2007, ch. 6",
    fluid=True,
)
