"""Blow-off valves: beyond a knee of each direction the slope changes, c (|v| - v_k)^2 / (|v| - v_k + v_w)."""

from er_models.effect import CONTACT, Effect, Param, Signature


def force(c_e: float, v_e: float, c_c: float, v_c: float, v_w: float, v: float) -> float:
    """Force [N] that the valves add once they open; none below the knees."""
    up = max(v - v_e, 0.0)
    down = max(-v - v_c, 0.0)
    return c_e * up * up / (up + v_w) - c_c * down * down / (down + v_w)


EFFECT = Effect(
    name="blow_off_valve",
    stage="force",
    title="Blow-off valves (a knee in each direction)",
    physics="Shims or a spring-loaded valve open at a pressure and leave the fluid more room: the slope falls "
    "(digressive, c < 0). Where the way is narrow beyond the valve it rises (progressive, c > 0). Each direction has a "
    "valve of its own.",
    parameters=(
        Param("c_e", "N s/m", -10.0, 20.0, 0.0, (0.3,), "change of slope in extension"),
        Param(
            "v_e", "m/s", 0.15, 1.0, None, (0.25, 0.5), "velocity at which it opens", step=CONTACT
        ),
        Param("c_c", "N s/m", -10.0, 20.0, 0.0, (0.3, -0.3), "change of slope in compression"),
        Param(
            "v_c",
            "m/s",
            0.15,
            1.0,
            None,
            (0.25, 0.5),
            "velocity at which that opens",
            step=CONTACT,
        ),
        Param("v_w", "m/s", 1e-3, 1.0, None, (0.02,), "width of the knees"),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="two straight lines that meet in a knee, in each direction another",
        plane="force-velocity",
        experiment="sines of one frequency and several strokes up to the fastest, zero duty",
        rivals=("asymmetric_damping", "quadratic_damping", "shear_thinning", "cavitation"),
        needs=("fast_extension", "fast_compression", "slow"),
    ),
    source="Dixon 2007, The Shock Absorber Handbook, ch. 6 (knees of valves); Lang 1977, A Study of the "
    "Characteristics of Automotive Hydraulic Dampers at High Stroking Frequencies",
    fluid=True,
)
