"""Cross-talk: the wires of the high voltage couple into those of the load cell."""

from er_models.effect import Effect, Param, Signature


def sense(K: float, f_m: float, u: float) -> float:
    """Reported force [N]: K per duty more than the true one."""
    return f_m + K * u


EFFECT = Effect(
    name="voltage_crosstalk",
    stage="sensing",
    title="Cross-talk of the high voltage",
    physics="The wires of the high voltage couple into those of the load cell, which then "
    "shows a force that follows the duty, moving or not.",
    parameters=(
        # name, unit, lower and upper bound, neutral value, starts: multiples of the natural scale
        Param("K", "N/duty", -2.0, 2.0, 0.0, (0.05, -0.05), "force shown per duty"),
    ),
    hooks={"sense": sense},
    signature=Signature(
        mark="a force that follows the duty, also at standstill",
        plane="force-duty",
        experiment="steps of the duty at standstill",
        rivals=("preload",),
    ),
    source="own measurement with the damper unmounted",
)
