"""Shear thinning (n < 1) or thickening: viscosity goes as (1 + (v / v_r)^2)^((n - 1) / 2) (Carreau)."""

from er_models.effect import Effect, Param, Signature


def viscous_scale(n: float, v_r: float, v: float) -> float:
    """Factor on the viscous damping [1]."""
    return float((1.0 + (v / v_r) * (v / v_r)) ** (0.5 * (n - 1.0)))


EFFECT = Effect(
    name="shear_thinning",
    stage="force",
    title="Shear thinning or thickening",
    physics="A suspension flows more easily the faster it is sheared (n < 1), or less easily "
    "(n > 1).",
    parameters=(
        Param("n", "1", 0.1, 2.0, 1.0, (0.7, 1.2), "power law index"),
        Param("v_r", "m/s", 0.005, 0.5, None, (0.08,), "velocity where thinning begins"),
    ),
    hooks={"viscous_scale": viscous_scale},
    signature=Signature(
        mark="residual S-shaped and odd in velocity: more force than linear at low, less at "
        "high velocity",
        plane="force-velocity",
        experiment="fast large sine at zero duty",
        rivals=("quadratic_damping", "coulomb_friction"),
    ),
    source="Carreau 1972; Bird, Dai and Yarusso 1983",
    dissipative=True,
)
