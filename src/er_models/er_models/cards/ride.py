"""Pictures of the effects of the car, by simulation of the car on a sine road."""

from __future__ import annotations

import numpy as np

from er_models.cards.panel import CHANGE, CYCLES, DT, SCALES, WITH, WITHOUT, Curve, Panel
from er_models.catalogue import Catalogue
from er_models.effect import Effect
from er_models.model import Array, Model
from er_models.simulation import simulate

DUTY = 0.5 * SCALES.duty
BODY, WHEEL = (2.0, 1.2), (20.0, 0.6)
"""Frequency [Hz] and amplitude (of the damper's stroke) of the road that moves the body, and the wheel."""
CAR_EXPERIMENT = (
    "Amplitude over that of a sine road, duty 0.15. Blue: deflection; red: sprung mass."
)
RIDE_EXPERIMENT = (
    "Car on a sine road for 60 cycles, its last two shown: 2 Hz and 12 mm, for effects of the tyre 20 Hz and 6 mm; "
    "duty 0.15. Left: force of the tyre from both accelerations and the known masses. Grey: car without the effect; "
    "blue: with it; red: the difference."
)


def ride_panels(effect: Effect, catalogue: Catalogue) -> tuple[Panel, ...]:
    """The panels of an effect of the car; of the car itself, its resonances."""
    if effect.name == "quarter_car":
        return (_resonance(catalogue),)
    car = _car(catalogue)
    runs = [_run(car, effect), _run(car.with_effect(effect.name), effect)]
    across = "velocity" if effect.signature.plane.endswith("velocity") else "deflection"
    label = {"velocity": "velocity [m/s]", "deflection": "deflection [mm]"}[across]
    return (
        _panel("tyre deflection [mm]", "tyre force [N]", runs, "tyre", "force"),
        _panel(label, "body acceleration [m/s2]", runs, across, "acceleration"),
    )


def _car(catalogue: Catalogue) -> Model:
    """A car with a damper, at their first starts."""
    model = Model("card", {}, SCALES, catalogue=catalogue)
    for name in ("passive", "guo_yield", "response", "quarter_car"):
        model = model.with_effect(name)
    return model


def _run(car: Model, effect: Effect) -> dict[str, Array]:
    """What is drawn of a run: the last cycles of the road for this effect."""
    tyre = any(hook.startswith("tyre") for hook in effect.hooks)
    frequency, amplitude = WHEEL if tyre else BODY
    dt, values = 0.01 / frequency, car.effects["quarter_car"]
    t = np.arange(6000) * dt
    road = amplitude * SCALES.deflection * np.sin(2.0 * np.pi * frequency * t)
    run = {
        k: y[-100 * CYCLES - 1 :]
        for k, y in simulate(car, dt, road, np.full(t.size, DUTY)).items()
    }
    a_s, a_us = run["sprung_acceleration"], run["unsprung_acceleration"]
    return {
        "deflection": 1e3 * run["deflection"],
        "velocity": run["deflection_velocity"],
        "tyre": 1e3 * run["tyre_deflection"],
        "acceleration": a_s,
        "force": -values["m_s"] * a_s - values["m_us"] * a_us,
    }


def _panel(x_label: str, y_label: str, runs: list[dict[str, Array]], x: str, y: str) -> Panel:
    """One quantity over another without the effect and with it, and the change with time on the same axis."""
    without, with_it = runs
    curves = (
        Curve(without[x], without[y], WITHOUT),
        Curve(with_it[x], with_it[y], WITH),
        Curve(without[x], with_it[y] - without[y], CHANGE),
    )
    return Panel(x_label, y_label, curves)


def _resonance(catalogue: Catalogue) -> Panel:
    """Amplitudes of deflection and sprung mass over that of the road, by simulation of each frequency."""
    model, frequencies, rows = _car(catalogue), np.geomspace(0.5, 30.0, 25), []
    for f in frequencies:
        n = round((2.0 + 6.0 / f) / DT)
        road = 0.1 * SCALES.deflection * np.sin(2.0 * np.pi * f * np.arange(n) * DT)
        run = simulate(model, DT, road, np.full(n, DUTY))
        last = slice(-max(round(3.0 / f / DT), 2), None)
        sprung = run["deflection"] + run["tyre_deflection"] + run["road"]
        rows.append([np.ptp(y[last]) / np.ptp(road[last]) for y in (run["deflection"], sprung)])
    ratios = np.array(rows).T
    x = np.log10(frequencies)
    curves = (Curve(x, ratios[0], WITH), Curve(x, ratios[1], CHANGE))
    return Panel("log10 of frequency [Hz]", "amplitude ratio", curves)
