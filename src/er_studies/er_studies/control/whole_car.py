"""Controllers of the whole car beside one another: on random roads, and in turns and while braking on a smooth one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from er_ftc_controller.body_gains import load_body_gain
from er_models.car.body import Car
from er_models.car.files import load_car
from er_models.car.simulation import CarOutput, car_at_rest, prepare_car, step_car
from er_models.car.surface import four_roads
from er_models.model import Array
from er_models.program import Program, within
from er_models.simulation import substeps

from er_ftc_controller import body, skyhook

DT, SPEED, COHERENCE = 0.005, 3.0, 0.5
"""Sample time [s], speed of a car at one fifth [m/s], and how much both tracks share."""
ROAD = {"kind": "iso8608", "road_class": "C", "speed": 15.0, "factor": 0.2}
COLUMNS = (
    "seat [m/s2]",
    "heave [m/s2]",
    "roll [rad/s2]",
    "pitch [rad/s2]",
    "deflection [mm]",
    "tyre [mm]",
)
"""What a row holds, each as root mean square."""
LIMITS = (0.0, 0.3)
Law = Callable[[body.BodySample], Array]


def constant(duty: float) -> Law:
    """The same duty everywhere."""
    return lambda _: np.full(4, duty)


def skyhooks(duty: float) -> Law:
    """Two-state Skyhook at every corner, up to a duty."""
    law, states = skyhook.Skyhook(0.0, duty, 0.1), [skyhook.START] * 4

    def answer(m: body.BodySample) -> Array:
        duties = []
        for i in range(4):
            sample = skyhook.Sample(m.t, float(m.sprung[i]), float(m.v[i]))
            states[i], command = skyhook.step(law, states[i], sample)
            duties.append(command.duty)
        return np.array(duties)

    return answer


def regulator(car: Car, gains: Path) -> Law:
    """The body controller with a gain file."""
    gain, _ = load_body_gain(gains, car)
    law, held = body.law_of(car, gain, LIMITS, 0.02, 0.1), [body.start()]

    def answer(m: body.BodySample) -> Array:
        held[0], duties = body.step(law, held[0], m)
        return duties

    return answer


def rows(
    config: Path, seeds: int, seconds: float, first: int = 0
) -> Iterator[tuple[str, str, Array]]:
    """Name of the ride, name of the controller, and its row (6,) of `COLUMNS`, one after the other."""
    car = load_car(config / "cars/inove_car.yaml")
    laws: dict[str, Callable[[], Law]] = {
        "no field": lambda: constant(0.0), "duty 0.05": lambda: constant(0.05), "duty 0.1": lambda: constant(0.1),
        "Skyhook, 0.1": lambda: skyhooks(0.1), "body_controller": lambda: regulator(car, config /
        "gains/body_lqr.yaml"),
    }  # fmt: skip
    for name, make in laws.items():
        found = [drive(car, *rough(car, seconds, first + k), make()) for k in range(seeds)]
        yield "rough road", name, np.mean(found, axis=0)
    for name, make in laws.items():
        yield "turns and braking", name, drive(car, *handling(car), make())


def rough(car: Car, seconds: float, seed: int) -> tuple[Array, Array]:
    """Four roads of ISO class C at one fifth, (4, m), and no loads (n, 4)."""
    n = round(seconds / DT)
    t = within(n + 1, DT)
    program = Program(ROAD, {"kind": "constant", "level": 0.0}, seconds, seed)
    road = four_roads(program, car, SPEED, COHERENCE, t)
    return road - road[:, :1], np.zeros((n, 4))


def handling(car: Car) -> tuple[Array, Array]:
    """A smooth road; a turn to the left, one to the right, and braking, 10 s."""
    t = np.arange(round(10.0 / DT)) * DT
    left = np.where((t > 2) & (t < 4), 2.0, 0.0) - np.where((t >= 4) & (t < 6), 2.0, 0.0)
    forward = np.where((t > 7) & (t < 8.5), -3.0, 0.0)
    return np.zeros((4, t.size * substeps(DT) + 1)), car.push(forward, left)


def drive(car: Car, road: Array, loads: Array, law: Law) -> Array:
    """Root mean squares (6,) of a ride under a law."""
    plant, n = prepare_car(car, DT), len(loads)
    lines = substeps(DT)
    states, duty = car_at_rest(plant, road[:, 0], np.zeros(4)), np.zeros(4)
    motion, deflection, tyre = np.empty((n, 3)), np.empty((n, 4)), np.empty((n, 4))
    for k in range(n):
        ahead = road[:, k * lines + 1 : (k + 1) * lines + 1]
        states, out = step_car(plant, states, ahead, duty, loads[k])
        sample = read((k + 1) * DT, out)
        duty = law(sample)
        motion[k], deflection[k], tyre[k] = out.body, sample.x, [s.q[2] for s in states]
    seat = car.at(dict(zip(("heave", "roll", "pitch"), motion.T)), car.seat)
    found = [np.sqrt(np.mean(each**2)) for each in (seat, *motion.T, deflection, tyre)]
    return np.array(found) * [1, 1, 1, 1, 1e3, 1e3]


def read(t: float, out: CarOutput) -> body.BodySample:
    """What a controller reads, without noise."""
    values = zip(
        *(
            (c.deflection, c.deflection_velocity, c.sprung_acceleration, c.unsprung_acceleration)
            for c in out.corners
        )
    )
    return body.BodySample(t, *(np.array(each) for each in values))


def markdown(found: list[tuple[str, str, Array]]) -> str:
    """A table a ride; below its first row, changes against it in per cent."""
    text = []
    for ride in dict.fromkeys(name for name, _, _ in found):
        mine = [(law, row) for name, law, row in found if name == ride]
        text += [f"### {ride.capitalize()}", "", f"| | {' | '.join(COLUMNS)} |", "|---" * 7 + "|"]
        first = mine[0][1]
        text.append(f"| {mine[0][0]} | {' | '.join(f'{v:.3g}' for v in first)} |")
        text += [
            f"| {law} | {' | '.join(f'{100 * (v / b - 1):+.0f} %' for v, b in zip(row, first))} |"
            for law, row in mine[1:]
        ]
        text.append("")
    return "\n".join(text).rstrip()
