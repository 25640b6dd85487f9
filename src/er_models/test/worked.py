"""What is worked out by hand of an effect, checked by the kernel; one file an effect in `effects/`.

A file holds `WORKED`, its values, and where the last `starts` do not show every parameter `SHOWN`, values [SI] at which
a record does. `ROAD` is the factor on the height of a road that an effect of the car needs to be seen.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from er_models.catalogue import Catalogue
from er_models.kernel.load import kernel
from er_models.model import Model
from er_models.prediction import motion, predict
from er_models.rhs import damper_rate
from models_help import DT, SMALL, one_sample

FOLDER = Path(__file__).parent / "effects"
Values = Mapping[str, float]
Effects = Mapping[str, Values]

PASSIVE: Effects = {"passive": {"k0": 100.0, "c0": 50.0}}
YIELD: Effects = {"guo_yield": {"f_c": 20.0, "k1": 0.0, "c1": 1000.0}}
"""At a velocity of 0.1 m/s the tanh is 1 to the last digit: 20 N per duty."""
CUBE: Effects = {"gas_spring": {"k_2": 0.0, "k_3": 1e6}}
"""Shows the deflection of the damper itself where its passive force does not."""
CAR: Effects = {"quarter_car": {"m_s": 2.0, "m_us": 0.5, "k_s": 1000.0, "k_t": 10000.0}}
"""With the passive damper in `STATE`: springs 10 N + 6 N on the body, 10 N of the tyre on the wheel."""
STATE = (0.01, 0.3, 0.001, 0.2, 0.05)
"""Deflection, velocity of the body, deflection of the tyre, velocity of the wheel, rate of the road [SI]."""


@dataclass(frozen=True)
class Case:
    """Values of the effect, and the effects beside it [SI]."""

    values: Values
    beside: Effects = field(default_factory=dict)

    def model(self, name: str, catalogue: Catalogue) -> Model:
        """The damper of both."""
        return Model(name, {**self.beside, name: self.values}, SMALL, catalogue=catalogue)


@dataclass(frozen=True)
class Force(Case):
    """Force [N] with every state in equilibrium."""

    x: float = 0.0
    v: float = 0.0
    u: float = 0.0
    a: float = 0.0
    theta: float = 0.0
    force: float = 0.0

    def check(self, name: str, catalogue: Catalogue) -> None:
        """Compare it with the kernel's."""
        sample = one_sample(self.x, self.v, self.u, self.a, self.theta)
        found = predict(self.model(name, catalogue), sample)
        assert found[0] == pytest.approx(self.force, rel=1e-7)


@dataclass(frozen=True)
class Rate(Case):
    """Rate of the state w, the effect's own or else the yield force, and the force [N]."""

    w: float = 0.0
    x: float = 0.0
    v: float = 0.0
    u: float = 0.0
    a: float = 0.0
    t: float = 0.0
    rate: float = 0.0
    force: float = 0.0

    def check(self, name: str, catalogue: Catalogue) -> None:
        """Compare both with the kernel's."""
        slot = catalogue.slots.get(name, catalogue.slots["response"])
        state = np.zeros(catalogue.n_states)
        state[slot] = self.w
        rates, found = damper_rate(
            self.model(name, catalogue), state, self.x, self.v, self.a, self.u, self.t
        )
        assert found == pytest.approx(self.force, rel=1e-7, abs=1e-9)
        assert rates[slot] == pytest.approx(self.rate, rel=1e-6)


@dataclass(frozen=True)
class Stroke(Case):
    """Force [N] after 0.05 s at one velocity, from where the states rest."""

    v: float = 0.0
    u: float = 0.0
    force: float = 0.0

    def check(self, name: str, catalogue: Catalogue) -> None:
        """Compare it with the kernel's."""
        t = np.arange(11) * DT
        inputs = motion(DT, self.v * t, 0.0 * t + self.v, 0.0 * t + self.u)
        found = predict(self.model(name, catalogue), inputs)
        assert found[-1] == pytest.approx(self.force, rel=1e-7)


@dataclass(frozen=True)
class Delay:
    """Delay [s] of the duty or the force; what it does to a record is in `test_integrator_damper.py`."""

    values: Values
    delay: float

    def check(self, name: str, catalogue: Catalogue) -> None:
        """Compare it with the hook's."""
        hooks = catalogue[name].hooks.items()
        assert [f(**self.values) for hook, f in hooks if hook.endswith("_delay")] == [self.delay]


@dataclass(frozen=True)
class Ride:
    """Accelerations of body and wheel that are reported [m/s2], of the car with a passive damper."""

    values: Values
    reported: tuple[float, float]
    state: tuple[float, float, float, float, float] = STATE

    def check(self, name: str, catalogue: Catalogue) -> None:
        """Compare them with the kernel's."""
        effects = {**PASSIVE, **CAR, name: self.values}
        c = Model(name, effects, SMALL, catalogue=catalogue).compiled(plant=True)
        x, v_s, z_t, v_us, road_rate = self.state
        w, rate, out = np.zeros(catalogue.n_states), np.zeros(catalogue.n_states), np.zeros((1, 6))
        kernel(catalogue).vehicle_point(
            c.on, c.slots, c.links, c.p, np.array([x, v_s, z_t, v_us]), w, 0.0, 0.0, 0.0, road_rate, rate, rate, out
        )  # fmt: skip
        assert out[0, 4:] == pytest.approx(self.reported, rel=1e-9)


def fault(*, stiffness: float, viscosity: float, field: float) -> tuple[Rate, ...]:
    """A fault that leaves 0.6: which shares it takes of 1 N of stiffness, 5 N of viscosity and 6 N of yield force."""
    times = (  # when, growth [s], share of a period without it, part of the fault there is
        (1.9, 0.0, 0.0, 0.0),
        (2.0, 0.0, 0.0, 0.4),
        (2.5, 1.0, 0.0, 0.2),
        (50.0, 1.0, 0.0, 0.4),
        (3.5, 0.0, 0.25, 0.0),
        (6.5, 1.0, 0.25, 0.2),
    )
    return tuple(
        Rate(
            {"f": 0.6, "t_0": 2.0, "t_r": t_r, "q": q, "d": 0.25}, {**PASSIVE, **YIELD}, x=0.01, v=0.1, u=0.3, t=t,
            force=12.0 - loss * (stiffness + 5.0 * viscosity + 6.0 * field),
        )
        for t, t_r, q, loss in times
    )  # fmt: skip


def of(name: str) -> Any:
    """The file of an effect, as a module."""
    spec = importlib.util.spec_from_file_location(f"worked_{name}", FOLDER / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
