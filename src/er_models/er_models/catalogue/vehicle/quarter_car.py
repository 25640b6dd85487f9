"""Quarter car (2.1)-(2.3): two masses, the suspension spring and the tyre spring."""

from er_models.effect import Effect, Param, Signature


def spring_force(k_s: float, x: float) -> float:
    """Force of the suspension spring [N], (2.2)."""
    return k_s * x


def tyre_force(k_t: float, z_t: float) -> float:
    """Force of the tyre [N], (2.3); z_t is z_us - z_r."""
    return k_t * z_t


def sprung_mass(m_s: float) -> float:
    """Sprung mass [kg]."""
    return m_s


def unsprung_mass(m_us: float) -> float:
    """Unsprung mass [kg]."""
    return m_us


EFFECT = Effect(
    name="quarter_car",
    stage="vehicle",
    title="Quarter car",
    physics="Body and wheel as two masses; the suspension spring between them, the tyre as a "
    "spring to the road.",
    parameters=(
        Param("m_s", "kg", 0.0, 1e6, None, (1.0,), "sprung mass", fitted=False),
        Param("m_us", "kg", 0.0, 1e6, None, (0.1,), "unsprung mass", fitted=False),
        Param("k_s", "N/m", 0.0, 1e6, 0.0, (1.0,), "suspension spring", fitted=False),
        Param("k_t", "N/m", 0.0, 1e6, 0.0, (10.0,), "tyre spring", fitted=False),
    ),
    hooks={
        "spring_force": spring_force,
        "tyre_force": tyre_force,
        "sprung_mass": sprung_mass,
        "unsprung_mass": unsprung_mass,
    },
    signature=Signature(
        mark="resonances of body and wheel",
        plane="frequency",
        experiment="sweep of the road",
    ),
    source="thesis (2.1)-(2.5), Table 2.1",
)
