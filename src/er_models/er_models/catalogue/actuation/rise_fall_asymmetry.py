"""Rise and fall differ: the yield force falls with r tau."""

from er_models.effect import Effect, Param, Signature


def tau_scale(r: float, y: float, f_y: float) -> float:
    """Factor on the response time [1]: r while the yield force shrinks, 1 while it grows, r^(1/2) at rest and at zero.

    The powers pass into one another where |f_y| is a few hundredths of |y|: a step there jumps with every
    parameter that moves the instant of the zero, and no least squares gets over a sum of such jumps. So they do
    within a thousandth of the target: on a plateau its last digit would say how fast the force leaves it.
    """
    towards = f_y / (abs(f_y) + 0.05 * abs(y) + 1e-12)
    rising = (y - f_y) / (abs(y - f_y) + 1e-3 * abs(y) + 1e-12)
    return float(r ** (0.5 - 0.5 * towards * rising))


EFFECT = Effect(
    name="rise_fall_asymmetry",
    stage="actuation",
    title="Rise-fall asymmetry of the response",
    physics="Chains break faster (or slower) than they form.",
    parameters=(
        Param(
            "r",
            "1",
            0.1,
            5.0,
            1.0,
            (1.4, 0.7),
            "time constant of the fall over that of the rise",
        ),
    ),
    hooks={"tau_scale": tau_scale},
    signature=Signature(
        mark="residual pulses after the duty falls, other than after it rises",
        plane="time",
        experiment="square wave of duty on a large slow sine",
        rivals=("varying_time_constant", "dead_time"),
        needs=("duty_rises", "duty_falls"),
    ),
    source="Koo, Goncalves and Ahmadian 2006; Choi et al. 1998",
)
