"""Damping of the tyre: c_t (z_us' - z_r')."""

from er_models.effect import Effect, Param, Signature


def tyre_force(c_t: float, v_t: float) -> float:
    """Viscous part of the tyre's force [N]."""
    return c_t * v_t


EFFECT = Effect(
    name="tyre_damping",
    stage="vehicle",
    title="Damping of the tyre",
    physics="The rubber of the tyre loses energy when it is squeezed: a damper beside the spring of the "
    "tyre. It feels the rate of the road, so the wheel's acceleration answers the road's rate at once.",
    parameters=(Param("c_t", "N s/m", 0.0, 2.0, 0.0, (0.05,), "damping of the tyre"),),
    hooks={"tyre_force": tyre_force},
    signature=Signature(
        mark="the resonance of the wheel is lower and wider than damper and springs make it",
        plane="frequency",
        experiment="sweep of the road through the resonance of the wheel, at zero duty",
        rivals=("tyre_lift_off", "guide_friction"),
    ),
    source="Levitt and Zorka 1991, J. Dyn. Syst. Meas. Control 113",
    dissipative=True,
)
