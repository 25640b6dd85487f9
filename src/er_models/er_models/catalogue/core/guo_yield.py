"""Yield force of the extended Guo model (1.10): f_c u tanh(k1 x + c1 v)."""

from math import tanh

from er_models.effect import Effect, Param, Signature


def target(f_c: float, k1: float, c1: float, x: float, v: float, u: float) -> float:
    """Yield force that the field asks for [N]."""
    return f_c * u * tanh(k1 * x + c1 * v)


EFFECT = Effect(
    name="guo_yield",
    stage="core",
    title="Yield force of the electrorheological fluid (Guo)",
    physics="The field lets particles form chains; the chains yield at a force proportional to the duty, "
    "after a narrow pre-yield range that leans with the deflection.",
    parameters=(
        Param("f_c", "N/duty", 0.0, 20.0, 0.0, (0.5,), "yield force per duty"),
        Param(
            "k1",
            "1/m",
            -20.0,
            20.0,
            None,
            (1.0, 0.0),
            "lean of the pre-yield range with deflection",
        ),
        Param("c1", "s/m", 0.5, 400.0, None, (10.0, 50.0), "steepness of the pre-yield range"),
    ),
    hooks={"target": target},
    signature=Signature(
        mark="a step in force-velocity whose height follows the duty",
        plane="force-velocity",
        experiment="sine at several constant duties",
    ),
    source="thesis (1.10), (1.12); Guo, Yang and Pan 2006",
)
