"""Guo's yield force with own values in compression and release (Table 1.3): f_c u tanh(k1 x + c1 v) of each.

At v = 0 the target jumps from f_c_c u tanh(k1_c x) to f_c_r u tanh(k1_r x); here it happens within v_0.
"""

from math import tanh

from er_models.effect import Effect, Param, Signature


def target(
    f_c_c: float, k1_c: float, c1_c: float, f_c_r: float, k1_r: float, c1_r: float, v_0: float,
    x: float, v: float, u: float,
) -> float:  # fmt: skip
    """Yield force that the field asks for [N]."""
    s = 0.5 + 0.5 * tanh(v / v_0)
    compression = f_c_c * tanh(k1_c * x + c1_c * v)
    release = f_c_r * tanh(k1_r * x + c1_r * v)
    return u * (compression + (release - compression) * s)


EFFECT = Effect(
    name="guo_yield_by_direction",
    stage="core",
    title="Yield force of the electrorheological fluid by direction (Guo)",
    physics="Guo's yield force with one set of values in compression (negative velocity) and one in release "
    "(positive). It stands in place of the yield force with one set.",
    parameters=(
        Param("f_c_c", "N/duty", 0.0, 20.0, 0.0, (0.55,), "yield force per duty in compression"),
        Param(
            "k1_c", "1/m", -20.0, 20.0, None, (1.0,), "lean of the pre-yield range in compression"
        ),
        Param("c1_c", "s/m", 0.5, 400.0, None, (10.0, 50.0), "its steepness in compression"),
        Param("f_c_r", "N/duty", 0.0, 20.0, 0.0, (0.45,), "yield force per duty in release"),
        Param("k1_r", "1/m", -20.0, 20.0, None, (1.0,), "lean of the pre-yield range in release"),
        Param("c1_r", "s/m", 0.5, 400.0, None, (10.0, 50.0), "its steepness in release"),
        Param(
            "v_0",
            "m/s",
            1e-4,
            0.5,
            None,
            (0.005,),
            "width of the change of direction",
            fitted=False,
        ),
    ),
    hooks={"target": target},
    signature=Signature(
        mark="a step in force-velocity whose height follows the duty, another one up than down",
        plane="force-velocity",
        experiment="sine at several constant duties",
        rivals=("guo_yield", "asymmetric_damping"),
    ),
    source="thesis (1.12), Table 1.3",
)
