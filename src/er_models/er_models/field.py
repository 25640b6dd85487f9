"""From duty to voltage, electric field and yield force: Table 1.1 and equations (1.1) to (1.6).

Two misprints of the thesis are set right. (1.2) gives the viscous term as 6 mu L / (pi d^3 R) v, which is a
pressure per area, not a force: with the flow (A_p - A_s) v through the duct and the pressure acting on A_p - A_s
it takes the factor (A_p - A_s)^2. (1.4) and (1.5) raise -U_m / d to the power beta, which is not real for
most beta: the sign of a field means nothing to the fluid, so its magnitude counts.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

VOLTAGE_MAX = 5000.0
"""Voltage of the testbench's amplifier at duty 1 [V] (Table 1.1)."""


@dataclass(frozen=True, slots=True)
class Duct:
    """Annular duct between the electrodes (thesis figure 1.6).

    area_piston, area_rod: A_p, A_s [m2]; length, radius, gap: L_d, R_d, d [m]; c: coefficient of the
    velocity profile [1], 2 to 3 in the literature.
    """

    area_piston: float
    area_rod: float
    length: float
    radius: float
    gap: float
    c: float

    @property
    def area(self) -> float:
        """Area on which the pressure drop acts, A_p - A_s [m2]."""
        return self.area_piston - self.area_rod


def voltage(duty: float, voltage_max: float = VOLTAGE_MAX) -> float:
    """Voltage between the electrodes [V]: in proportion to the duty of the PWM signal (Table 1.1)."""
    return voltage_max * duty


def electric_field(duty: float, gap: float, voltage_max: float = VOLTAGE_MAX) -> float:
    """Magnitude of the field [V/m] between electrodes `gap` [m] apart (1.4); uniform where d << R_d."""
    return voltage(duty, voltage_max) / gap


def yield_stress(field: float, alpha: float, beta: float) -> float:
    """Yield stress of the fluid [Pa] in a field [V/m]: alpha E^beta, alpha in Pa (m/V)^beta."""
    return alpha * field**beta if field > 0.0 else 0.0


def yield_force(duct: Duct, stress: float) -> float:
    """Force of the yield stress [Pa] in steady flow [N], the third term of (1.2)."""
    return duct.area * duct.c * duct.length / duct.gap * stress


def sigma(duct: Duct, alpha: float, beta: float, voltage_max: float = VOLTAGE_MAX) -> float:
    """Yield force at duty 1 [N], the sigma of (1.5); the force at any duty is sigma duty^beta."""
    return yield_force(duct, yield_stress(electric_field(1.0, duct.gap, voltage_max), alpha, beta))


def viscous_damping(duct: Duct, viscosity: float) -> float:
    """Damping c0 [N s/m] of a fluid of this viscosity [Pa s] without field, the second term of (1.2)."""
    return 6.0 * viscosity * duct.length * duct.area**2 / (pi * duct.gap**3 * duct.radius)


def force_of_pressures(duct: Duct, gas: float, drop: float) -> float:
    """Damper force [N] of the gas pressure and the pressure drop in the duct [Pa] (1.1)."""
    return gas * duct.area_rod + drop * duct.area
