"""Lag of the high-voltage amplifier: T_a w' + w = u."""

from er_models.effect import SHORTEST, Effect, Param, Signature


def relax(T_a: float, u: float) -> tuple[float, float]:
    """Rate [1/s] and drive [1/s] of the voltage, in duty."""
    rate = 1.0 / max(T_a, SHORTEST)
    return rate, rate * u


def duty(w: float) -> float:
    """Duty that the fluid sees [1]."""
    return w


EFFECT = Effect(
    name="amplifier_lag",
    stage="actuation",
    title="Lag of the amplifier",
    physics="The electrodes charge through the amplifier's resistance: the voltage follows "
    "the duty with a lag.",
    parameters=(Param("T_a", "s", 0.0, 0.5, 0.0, (0.005, 0.02), "time constant"),),
    hooks={"relax": relax, "duty": duty},
    signature=Signature(
        mark="residual after steps of the duty, but not after reversals of the motion",
        plane="time",
        experiment="square wave of duty on a large slow sine",
        rivals=("dead_time", "varying_time_constant"),
        needs=("duty_rises", "duty_falls"),
    ),
    source="RC charging of the electrode gap; Koo, Goncalves and Ahmadian 2006",
)
