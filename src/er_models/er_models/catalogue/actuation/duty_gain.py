"""Gain of the high-voltage chain: g_u u."""

from er_models.effect import Effect, Param, Signature


def duty(g_u: float, u: float) -> float:
    """Duty that acts [1]."""
    return g_u * u


EFFECT = Effect(
    name="duty_gain",
    stage="actuation",
    title="Gain of the high-voltage chain",
    physics="The amplifier makes g_u times the voltage that the duty asks for.",
    parameters=(Param("g_u", "1", 0.2, 5.0, 1.0, (1.1,), "acting over commanded duty"),),
    hooks={"duty": duty},
    signature=Signature(
        mark="every yield force is off by the same factor",
        plane="force-duty",
        experiment="voltmeter on the electrodes",
        rivals=("guo_yield", "bingham_yield", "field_exponent", "duty_dead_band"),
    ),
    source="model of the actuation chain",
    knowable=False,
    unknowable_because="f_c (Guo) takes up a scale g of the duty exactly, and so does sigma (Bingham) through "
    "g^beta; fitted terms in the duty (field_viscosity, duty_dead_band, varying_time_constant) scale along. Only a "
    "term that is known beforehand as a function of the duty, as a response time from a table, would show it. "
    "Measure the voltage.",
)
