"""Progressive gas spring: k_2 x^2 + k_3 x^3, the next terms of the polytropic gas law, over what is left of the gas.

Where the stroke uses up much of the gas column the terms beyond the cubic one count, too: each is about the one before
it times -e_g x, and so their sum is a division by 1 + e_g x.
"""

from er_models.effect import Effect, Param, Signature

LEAST = 0.1
"""Share of the gas column that is left at least: a motion beyond it divides by no less."""


def force(k_2: float, k_3: float, e_g: float, x: float) -> float:
    """Progressive part of the gas force [N]."""
    return (k_2 * x * x + k_3 * x * x * x) / max(1.0 + e_g * x, LEAST)


EFFECT = Effect(
    name="gas_spring",
    stage="force",
    title="Progressive gas spring",
    physics="Compressing the gas raises its pressure more than in proportion; the same terms "
    "describe a cubic (hardening) spring.",
    parameters=(
        Param("k_2", "N/m2", -10.0, 10.0, 0.0, (0.2, -0.2), "quadratic stiffness"),
        Param("k_3", "N/m3", -10.0, 10.0, 0.0, (0.2,), "cubic stiffness"),
        Param(
            "e_g", "1/m", -0.85, 0.85, 0.0, (-0.3, 0.3), "one over the gas column", optional=True
        ),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="residual curves in force-deflection, the same in both directions of motion",
        plane="force-deflection",
        experiment="slow sine over the whole stroke at zero duty",
        rivals=("end_stop", "asymmetric_damping", "deflection_zero"),
        needs=("far_extension", "far_compression"),
    ),
    source="polytropic gas law; Duffing oscillator; Dixon 2007, The Shock Absorber Handbook, "
    "ch. 4",
)
