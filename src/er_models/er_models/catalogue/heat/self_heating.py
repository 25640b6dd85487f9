"""Self-heating: dissipated power, low-pass filtered, thins the fluid and weakens the chains."""

from math import exp

from er_models.effect import Effect, Param, Signature


def relax(t_h: float, f_d: float, v: float) -> tuple[float, float]:
    """Rate [1/s] and drive [W/s] of the heat flow through the wall."""
    return 1.0 / t_h, abs(f_d * v) / t_h


def viscous_scale(b_v: float, w: float) -> float:
    """Factor on the viscosity [1]."""
    return exp(-b_v * w)


def yield_scale(b_y: float, w: float) -> float:
    """Factor on the yield force [1]."""
    return exp(-b_y * w)


EFFECT = Effect(
    name="self_heating",
    stage="heat",
    title="Self-heating",
    physics="The damper warms by the power it dissipates; warm fluid is thinner and yields "
    "earlier. Temperature rise is heat flow times thermal resistance, which these "
    "channels cannot tell apart.",
    parameters=(
        Param("t_h", "s", 2.0, 2000.0, None, (20.0, 100.0), "thermal time constant"),
        Param("b_v", "1/W", -0.5, 20.0, 0.0, (0.5,), "loss of viscosity per watt"),
        Param("b_y", "1/W", -0.5, 10.0, 0.0, (0.5,), "loss of yield force per watt"),
    ),
    hooks={"relax": relax, "viscous_scale": viscous_scale, "yield_scale": yield_scale},
    signature=Signature(
        mark="damping fades with the work done and recovers at rest",
        plane="time",
        experiment="soak at high power, then rest, then the first run again",
        rivals=("effectiveness_fade", "force_fade"),
        needs=("minutes", "load_change"),
    ),
    source="lumped thermal model; Dixon 2007, ch. 3; Batterbee and Sims 2009",
    initial="zero",
)
