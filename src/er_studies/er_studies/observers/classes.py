"""ISO roads of classes A to E, healthy, with faults, friction and load: what observers and peers are scored on."""

from __future__ import annotations

from dataclasses import replace

from er_models.program import Program

from er_studies.observers.scenarios.scenario import Plant, Scenario, Skyhook, Window

CLASSES = "ABCDE"
SCORED, TUNING = 9001, 8001
"""Seeds of the first road that is scored, and of the first that peers are tuned on."""
MICROMETRES = (10, 20, 100, 200)
"""Noise of the deflection sensor [um]; 20 is that of the rig's file."""


def _fault(name: str, left: float, begin: float = 0.0) -> dict[str, dict[str, float]]:
    return {name: {"f": left, "t_0": begin, "t_r": 0.0, "q": 0.0, "d": 0.5}}


CASES = {
    "healthy": {},
    "f1": _fault("electrical_fault", 0.5),
    "f2": _fault("oil_leakage", 0.6),
    "f3": _fault("duct_deformation", 0.6),
    "f2_appears": _fault("oil_leakage", 0.6, 8.0),
    "friction": {"coulomb_friction": {"F_c": 1.0, "v_0": 0.003}},
    "heavy": {"sprung_mass_error": {"e": 0.2}},
    "light": {"sprung_mass_error": {"e": -0.1}},
    "heavy_f2_appears": {"sprung_mass_error": {"e": 0.2}, **_fault("oil_leakage", 0.6, 8.0)},
}
"""What is hidden in the plant."""


def scenario(road_class: str, case: str, seed: int = SCORED, duration: float = 20.0) -> Scenario:
    """A drive on a road of a class at 60 km/h under Skyhook with duties 0 and 0.3; errors count from 2 s on."""
    road = {"kind": "iso8608", "road_class": road_class}
    return Scenario(
        f"{road_class}/{case}",
        f"class {road_class}, {case}",
        Program(road, {"kind": "constant", "level": 0.0}, duration, seed),
        (Window(2.0, duration),),
        start="own",
        skyhook=Skyhook(0.0, 0.3),
        plant=Plant(effects=CASES[case]),
    )


def with_noise(s: Scenario, micrometres: float) -> Scenario:
    """The same with another deflection sensor; 0: without one."""
    noise = 1e-6 * micrometres if micrometres else float("nan")
    return replace(s, sensors=replace(s.sensors, deflection=noise))
