"""Where each state and each effect lives in the arrays of the integrator."""

from __future__ import annotations

# States: car, field force, joint, hysteresis, Maxwell branches, void, field, amplifier, heat, tyre.
ZS, VS, ZU, VU, FER, XD, VD, HYS, MX1, MX2, VOID, FLD, AM1, AM2, TF, TW, TYR = range(17)
N_STATES = 17

# Memory updated once per step, not by the rates: last turning point, last stroke, last direction, share of the
# rod's force that is left.
TURN, STROKE, DIRECTION, LEFT = range(4)
N_MEMORY = 4

# Base damper and car.
K0, C0, FC, K1, C1, TAU = range(6)
MS, MU, KS, KT = range(4)

# Channels of the fine trajectory.
OX, OV, OF, OAS, OAU, OXD, OFER, OTH, OVS, OVU, OZS, OZU = range(12)
N_OUT = 12

# Rows of the effect table; column 0 is always the strength, zero meaning "not there".
(
    GAS_SPRING,
    PRELOAD,
    COULOMB,
    STRIBECK,
    QUADRATIC,
    ASYMMETRIC,
    THINNING,
    POSITION,
    END_STOP,
    HYSTERESIS,
    VISCOELASTIC,
    INERTIA,
    MOUNT,
    FREEPLAY,
    CAVITATION,
    FIELD_VISCOSITY,
    FIELD_STIFFNESS,
    VARYING_TAU,
    RISE_FALL,
    DEAD_TIME,
    EXPONENT,
    DEAD_BAND,
    AMPLIFIER,
    HEATING,
    FADE,
    FORCE_DELAY,
    FORCE_LAG,
    VELOCITY_LAG,
    DEFLECTION_ZERO,
    OUT_COGGING,
    OUT_HUM,
    OUT_COUPLING,
    OUT_MEMORY,
    OUT_DRIFT,
    OUT_STICK,
    OUT_RESONANCE,
    OUT_CROSSTALK,
    TYRE_DAMPING,
    TYRE_LIFT,
    GUIDE,
    SPRING,
    MASS,
    BIAS,
    WHOLE_FADE,
) = range(44)
N_EFFECTS = 44
N_COLUMNS = 7
