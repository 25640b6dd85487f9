"""Bingham's yield force with own values in compression and release (Table 1.2), with a smooth sign."""

from math import tanh

from er_models.effect import Effect, Param, Signature


def target(
    sigma_c: float, beta_c: float, sigma_r: float, beta_r: float, v_0: float, v: float, u: float
) -> float:
    """Yield force that the field asks for [N]; zero without field."""
    s = 0.5 + 0.5 * tanh(v / v_0)
    compression = sigma_c * max(u, 1e-12) ** beta_c
    release = sigma_r * max(u, 1e-12) ** beta_r
    return (compression + (release - compression) * s) * tanh(v / v_0) if u > 0.0 else 0.0


EFFECT = Effect(
    name="bingham_yield_by_direction",
    stage="core",
    title="Yield force of the electrorheological fluid by direction (Bingham)",
    physics="Bingham's yield force with one set of values in compression (negative velocity) and one in "
    "release (positive). It stands in place of the yield force with one set.",
    parameters=(
        Param("sigma_c", "N", 0.0, 20.0, 0.0, (0.55,), "yield force at duty 1 in compression"),
        Param("beta_c", "1", 0.05, 3.0, None, (0.5, 1.0), "exponent of the field in compression"),
        Param("sigma_r", "N", 0.0, 20.0, 0.0, (0.45,), "yield force at duty 1 in release"),
        Param("beta_r", "1", 0.05, 3.0, None, (0.5, 1.0), "exponent of the field in release"),
        Param("v_0", "m/s", 1e-4, 0.5, None, (0.005,), "width of the smooth sign", fitted=False),
    ),
    hooks={"target": target},
    signature=Signature(
        mark="a step in force-velocity at zero velocity, another one up than down",
        plane="force-velocity",
        experiment="sine at several constant duties",
        rivals=("bingham_yield", "asymmetric_damping"),
    ),
    source="thesis (1.8), Table 1.2",
)
