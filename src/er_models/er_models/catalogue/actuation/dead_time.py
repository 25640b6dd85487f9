"""Dead time of the high-voltage chain: u(t - T_d)."""

from er_models.effect import Effect, Param, Signature


def input_delay(T_d: float) -> float:
    """Delay of the duty [s]."""
    return T_d


EFFECT = Effect(
    name="dead_time",
    stage="actuation",
    title="Dead time of the actuation",
    physics="The amplifier answers a new duty only after a pause.",
    parameters=(Param("T_d", "s", 0.0, 0.1, 0.0, (0.002, 0.008, 0.016), "dead time"),),
    hooks={"input_delay": input_delay},
    signature=Signature(
        mark="residual pulses right after each step of the duty, then nothing",
        plane="time",
        experiment="square wave of duty, 5 Hz, on a large slow sine",
        rivals=("amplifier_lag", "rise_fall_asymmetry"),
        needs=("duty_rises", "duty_falls"),
    ),
    source="Koo, Goncalves and Ahmadian 2006",
)
