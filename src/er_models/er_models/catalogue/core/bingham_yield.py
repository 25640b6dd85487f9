"""Yield force of the extended Bingham model (1.5), (1.8): sigma u^beta sign(v), with a smooth sign."""

from math import tanh

from er_models.effect import Effect, Param, Signature


def target(sigma: float, beta: float, v_0: float, v: float, u: float) -> float:
    """Yield force that the field asks for [N]; zero without field."""
    return sigma * max(u, 1e-12) ** beta * tanh(v / v_0) if u > 0.0 else 0.0


EFFECT = Effect(
    name="bingham_yield",
    stage="core",
    title="Yield force of the electrorheological fluid (Bingham)",
    physics="A Bingham plastic: the chains yield at a force that grows as a power of the field and "
    "opposes the motion.",
    parameters=(
        Param("sigma", "N", 0.0, 20.0, 0.0, (0.5,), "yield force at duty 1"),
        Param("beta", "1", 0.05, 3.0, None, (0.5, 1.0), "exponent of the field"),
        Param("v_0", "m/s", 1e-4, 0.5, None, (0.005,), "width of the smooth sign", fitted=False),
    ),
    hooks={"target": target},
    signature=Signature(
        mark="a step in force-velocity at zero velocity whose height follows a power of the duty",
        plane="force-velocity",
        experiment="sine at several constant duties",
    ),
    source="thesis (1.5), (1.8), (1.23); Choi et al. 1998",
)
