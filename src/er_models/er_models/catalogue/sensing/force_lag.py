"""Lag of the force sensor: T_f w' + w = F_d."""

from er_models.effect import SHORTEST, Effect, Param, Signature


def relax(T_f: float, f_d: float) -> tuple[float, float]:
    """Rate [1/s] and drive [N/s] of the filtered force."""
    rate = 1.0 / max(T_f, SHORTEST)
    return rate, rate * f_d


def sense(w: float) -> float:
    """Measured force [N]."""
    return w


EFFECT = Effect(
    name="force_lag",
    stage="sensing",
    title="Lag of the force sensor",
    physics="The amplifier of the load cell filters: the measured force lags the true one and "
    "loses its corners.",
    parameters=(Param("T_f", "s", 0.0, 0.1, 0.0, (0.003,), "time constant of the filter"),),
    hooks={"relax": relax, "sense": sense},
    signature=Signature(
        mark="residual follows the rate of the force, corners are rounded",
        plane="time",
        experiment="fast sine with steps of the duty",
        rivals=("force_delay", "mount_compliance", "fluid_inertia"),
        needs=("reversals",),
    ),
    source="first-order anti-alias filter",
)
