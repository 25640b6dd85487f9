"""End stop: a bump rubber beyond |x| = x_b, harder the more it is pressed."""

from er_models.effect import Effect, Param, Signature


def force(k_b: float, x_b: float, k_c: float, x: float) -> float:
    """Force of the bump rubber [N]; zero inside the free stroke."""
    pressed = max(x - x_b, 0.0) - max(-x - x_b, 0.0)
    return (k_b + k_c * abs(pressed)) * pressed


EFFECT = Effect(
    name="end_stop",
    stage="force",
    title="End stop (bump rubber)",
    physics="Near the end of the stroke a rubber stop is touched and its stiffness adds; it grows as the rubber "
    "is pressed together.",
    parameters=(
        Param("k_b", "N/m", 0.0, 50.0, 0.0, (2.0,), "stiffness of the stop"),
        Param("x_b", "m", 0.2, 2.0, None, (0.6, 0.85, 1.05), "free stroke to each side"),
        Param("k_c", "N/m2", 0.0, 200.0, 0.0, (0.2,), "growth of the stiffness", optional=True),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="residual only beyond a certain deflection, zero inside",
        plane="force-deflection",
        experiment="slow sine over the whole stroke",
        rivals=("gas_spring",),
        needs=("far_extension", "far_compression"),
    ),
    source="Dixon 2007, ch. 4; bump rubber, whose stiffness grows in proportion to how far it is pressed",
)
