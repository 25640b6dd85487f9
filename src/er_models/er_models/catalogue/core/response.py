"""Response time of the fluid (1.7), (1.11): tau f_y' + f_y = y, a first-order lag of the yield force."""

from er_models.effect import SHORTEST, Effect, Param, Signature


def response_time(tau: float) -> float:
    """The same response time at every duty [s]."""
    return tau


def relax(tau_y: float, tau_scale: float, y: float) -> tuple[float, float]:
    """Rate [1/s] and drive [N/s] of the yield force; serves every effect that gives a response time."""
    rate = 1.0 / max(tau_y * tau_scale, SHORTEST)
    return rate, rate * y


EFFECT = Effect(
    name="response",
    stage="core",
    title="Response time of the fluid",
    physics="The chains need time to form and to break; the yield force follows the field with a lag. "
    "A model without this term is static.",
    parameters=(
        Param("tau", "s", 0.0, 1.0, 0.0, (0.03, 0.005), "time constant of the yield force"),
    ),
    hooks={"response_time": response_time, "relax": relax},
    signature=Signature(
        mark="the force lags the sign of the velocity and steps of the duty",
        plane="time",
        experiment="large slow sine with a square wave of duty",
    ),
    source="thesis (1.7), (1.11), (1.22), Table 1.6; Koo, Goncalves and Ahmadian 2006",
)
