"""Progressive suspension spring: k_3 ((x - x_c)^3 + x_c^3)."""

from er_models.effect import Effect, Param, Signature


def spring_force(k_3: float, x_c: float, x: float) -> float:
    """Progressive part of the suspension spring [N], zero at rest."""
    y = x - x_c
    return k_3 * (y * y * y + x_c * x_c * x_c)


EFFECT = Effect(
    name="spring_nonlinearity",
    stage="vehicle",
    title="Progressive suspension spring",
    physics="Coils that come to lie on one another and bump rubbers make the spring stiffer the further it "
    "is deflected. A cubic about its softest point x_c: x_c = 0 stiffens both ways, x_c > 0 mainly in "
    "compression. It never softens below the linear spring, so the car stays stable whatever the road.",
    parameters=(
        Param("k_3", "N/m3", 0.0, 10.0, 0.0, (1.0,), "cubic stiffness"),
        Param("x_c", "m", -2.0, 2.0, None, (0.0, 0.5), "deflection where the spring is softest"),
    ),
    hooks={"spring_force": spring_force},
    signature=Signature(
        mark="acceleration against deflection is curved; the resonance of the body leans to higher frequencies",
        plane="acceleration-deflection",
        experiment="slow sine of the road over the whole stroke at zero duty",
        rivals=("gas_spring", "end_stop", "sprung_mass_error"),
    ),
    source="Duffing oscillator; Gaspar, Szaszi and Bokor 2003 (cubic spring of the quarter car)",
)
