"""Tyre lift-off: the tyre can push but not pull, F_t <= r (m_s + m_us) g."""

from er_models.constants import g
from er_models.effect import CONTACT, Effect, Param, Signature


def tyre_limit(r: float, f_t: float, m_s: float, m_us: float) -> float:
    """Force of a tyre that only stands on the road [N]: it cannot release more than its static load."""
    return min(f_t, r * (m_s + m_us) * g)


EFFECT = Effect(
    name="tyre_lift_off",
    stage="vehicle",
    title="Tyre lift-off",
    physics="At rest the tyre carries the weight of both masses. Forces here count from that rest, so the "
    "tyre can give back its static load and no more: beyond the static compression the wheel is in the air, "
    "and gravity alone pulls it down. With damping in the tyre contact ends where the sum of spring and "
    "damper vanishes. Load that does not rest on the tyre (a held body) makes r less than 1.",
    parameters=(
        Param(
            "r",
            "1",
            0.05,
            1e6,
            float("inf"),
            (1.0, 0.5, 0.3),
            f"static load of the tyre over the weight, g = {g} m/s2",
            step=CONTACT,
        ),
    ),
    hooks={"tyre_limit": tyre_limit},
    signature=Signature(
        mark="the force of the tyre is cut off on one side; the wheel falls freely and lands",
        plane="tyre force-deflection",
        experiment="sweep of a rough road through the resonance of the wheel, at zero duty",
        rivals=("tyre_damping",),
    ),
    source="Lozia and Zdanowicz 2016, IOP Conf. Ser.: Mater. Sci. Eng. 148 (lift-off of the quarter car)",
)
