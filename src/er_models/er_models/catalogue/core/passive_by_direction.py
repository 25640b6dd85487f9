"""Passive force with own values in compression and release: k0(v) x + c0(v) v.

At v = 0 the stiffness jumps, and the force with it by (k0_r - k0_c) x: the thesis's model does this. Here
it happens within v_0. A stiffness that depends on the direction is no spring: each cycle of amplitude X
around an offset x_m gives the energy 2 (k0_c - k0_r) x_m X, where k0_c > k0_r and x_m > 0.
An element in series (mount, free play) takes the direction from the measured motion.
"""

from math import tanh

from er_models.effect import Effect, Param, Signature


def force(
    k0_c: float, c0_c: float, k0_r: float, c0_r: float, v_0: float, x: float, v: float,
    stiffness_scale: float, viscous_scale: float,
) -> float:  # fmt: skip
    """Passive force [N]."""
    s = 0.5 + 0.5 * tanh(v / v_0)
    k = k0_c + (k0_r - k0_c) * s
    c = c0_c + (c0_r - c0_c) * s
    return stiffness_scale * k * x + viscous_scale * c * v


def passive_stiffness(k0_c: float, k0_r: float, v_0: float, v: float) -> float:
    """Stiffness in this direction [N/m]."""
    return k0_c + (k0_r - k0_c) * (0.5 + 0.5 * tanh(v / v_0))


def passive_damping(c0_c: float, c0_r: float, v_0: float, v: float) -> float:
    """Damping in this direction [N s/m]."""
    return c0_c + (c0_r - c0_c) * (0.5 + 0.5 * tanh(v / v_0))


EFFECT = Effect(
    name="passive_by_direction",
    stage="core",
    title="Passive stiffness and viscosity by direction",
    physics="As the passive force, with one pair of values in compression (negative velocity) and one in "
    "release (positive), which takes in some friction and valve asymmetry. It stands in place of the "
    "passive force with one pair. The stiffness is no spring's: around an extended position it gives energy "
    "where k0_c exceeds k0_r. An element in series takes the direction from the measured motion.",
    parameters=(
        Param("k0_c", "N/m", -2.0, 20.0, 0.0, (0.12,), "effective stiffness in compression"),
        Param("c0_c", "N s/m", 0.0, 20.0, 0.0, (0.45,), "viscous damping in compression"),
        Param("k0_r", "N/m", -2.0, 20.0, 0.0, (0.08,), "effective stiffness in release"),
        Param("c0_r", "N s/m", 0.0, 20.0, 0.0, (0.55,), "viscous damping in release"),
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
    hooks={
        "force": force,
        "passive_stiffness": passive_stiffness,
        "passive_damping": passive_damping,
    },
    signature=Signature(
        mark="two half ellipses in force-deflection that do not meet, two slopes in force-velocity",
        plane="force-velocity",
        experiment="sine at zero duty",
        rivals=("asymmetric_damping", "coulomb_friction"),
    ),
    source="thesis Tables 1.2 and 1.3, section 1.5",
)
