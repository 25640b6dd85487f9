"""Gain of the velocity channel: the true velocity is v / g_v."""

from er_models.effect import Effect, Param, Signature


def shift_velocity(g_v: float, v: float) -> float:
    """Velocity before the sensor [m/s]."""
    return v / g_v


EFFECT = Effect(
    name="velocity_gain",
    stage="sensing",
    title="Gain of the velocity channel",
    physics="A velocity sensor that is out of scale: it reports g_v times the true velocity.",
    parameters=(Param("g_v", "1", 0.2, 5.0, 1.0, (1.1,), "reported over true velocity"),),
    hooks={"shift_velocity": shift_velocity},
    signature=Signature(
        mark="every slope against velocity is off by the same factor",
        plane="force-velocity",
        experiment="calibration of the sensor; or the deflection's own derivative beside the channel",
        rivals=("passive", "guo_yield", "bingham_yield", "velocity_lag"),
    ),
    source="model of the measurement chain",
    knowable=False,
    unknowable_because="c0 and c1 (Guo) or c0 and v_0 (Bingham) of the damper take up a scale of the velocity "
    "exactly. A deflection channel shows it without any force: its derivative must be the velocity.",
)
