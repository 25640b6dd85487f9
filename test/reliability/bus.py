"""Plant, injected faults and the cores of all nodes on one virtual clock: what a graph does, without its processes.

A tick goes as in the plant node: sensors out, duty decided with the newest command, duty out; whatever a core answers
arrives before the next tick. Every message passes the injection of the plant.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from functools import lru_cache
from random import Random
from typing import Any, NamedTuple

import yaml
from er_bringup.cores import entry
from er_bringup.programs import CORES, ESTIMATES
from er_common.program import OBSERVER
from er_common.stamps import CLOCK_STEP
from er_observers.programs import OBSERVERS
from er_plant_sim.build import build
from er_plant_sim.duty_gate import Command
from er_plant_sim.settings import PlantParameters
from er_ros_common.builders import Tick
from er_ros_common.core import Core, When
from er_ros_common.injection import Channel, asked, taken_over, through

from er_common import topics
from er_plant_sim import rig as plant
from er_plant_sim import ros_msgs
from test.graph_help import CONFIG, VEHICLE

SECOND = 1_000_000_000
STEADY, SYSTEM = 1000 * SECOND, 1_700_000_000 * SECOND
"""Readings of both clocks at the start."""
WATCH = 5_000_000
"""How often nodes look at the silence of their inputs [ns]; those of a real graph do every 5 or 10 ms."""
NAMES = tuple(program.name for program in OBSERVERS.values())
UNITS = {
    topics.ACCELERATION.name: ("sprung", "unsprung"),
    topics.DEFLECTION.name: ("deflection", "velocity"),
    topics.FORCE.name: ("force",),
    topics.PWM_APPLIED.name: ("duty",),
    topics.PWM_COMMAND.name: ("duty",),
}


class Heard(NamedTuple):
    """A message and when it was sent [s]."""

    t: float
    message: Any


def node_file(name: str) -> dict[str, Any]:
    """Parameters that belong to a kind of node."""
    text = (CONFIG / f"nodes/{name}.yaml").read_text()
    found: dict[str, Any] = yaml.safe_load(text)["/**"]["ros__parameters"]
    return found


@lru_cache(maxsize=16)
def core(name: str, *, deflection: bool = True) -> Core:
    """The core of a node with the parameters of its file; it keeps nothing between messages.

    deflection: whether an observer uses that sensor.
    """
    program, shell = CORES[name], entry(name)
    own = {"deflection": deflection} if program.kind == OBSERVER else node_file(name)
    given: dict[str, Any] = dict(own)
    if program.model:
        given["model_file"] = VEHICLE
    if program.gains:
        given["gains_file"] = str(CONFIG / f"gains/{program.gains}.yaml")
    return shell.make(shell.parameters(**given))


@lru_cache(maxsize=8)
def _rig(seed: int, duty_source: str) -> plant.Rig:
    """The plant with the noise of its file on the identification road."""
    known = {
        item.metadata["param"]["name"] or item.name: item.name for item in fields(PlantParameters)
    }
    given = {known[name]: value for name, value in node_file("plant").items()}
    program = str(CONFIG / "experiments/iso_steps.yaml")
    given |= {"model_file": VEHICLE, "program_file": program, "duration": 0.0, "seed": seed}
    return build(PlantParameters(**(given | {"duty_source": duty_source})))


class Bus:
    """One corner; `run` it, `inject` into it, and read `log`: every message by topic."""

    def __init__(
        self,
        names: Sequence[str] = (NAMES[0], "skyhook_controller"),
        *,
        seed: int = 1,
        duty_source: str = "topic",
        deflection: bool = True,
    ) -> None:
        self.rig = _rig(seed, duty_source)
        self.rig_state = plant.start(self.rig)
        self.cores = {name: core(name, deflection=deflection) for name in names}
        self.states = {name: each.start() for name, each in self.cores.items()}
        self.channels = {name: Channel() for name in UNITS}
        self.random, self.log = (
            Random(seed),
            {t.name: [] for t in topics.MEASUREMENTS + ESTIMATES},
        )
        self.steady, self.jump, self.anchor, self.skew = STEADY, 0, 0, 0
        self.conflict = False
        self.alive = set(names)
        self.between: Callable[[topics.Topic, Any], list[Any]] = lambda _, message: [message]

    @property
    def t(self) -> float:
        """Time since the start [s]."""
        return 1e-9 * (self.steady - STEADY)

    def inject(self, unit: str, kind: int, value: float = 0.0, duration: float = 0.0) -> None:
        """What the service of the plant does."""
        channel, fault = asked(unit, kind, value, duration, UNITS, self.t)
        self.channels[channel] = taken_over(self.channels[channel], fault, self.t)

    def run(self, seconds: float) -> None:
        """Run the ticks of this time."""
        for _ in range(round(seconds / self.rig.dt)):
            self.tick()

    def tick(self) -> None:
        """One tick of the plant."""
        number = self.rig_state.sim.tick
        if number % 200 == 0:
            # the plant looks at the system clock once a second
            self.anchor = self.jump if abs(self.jump - self.anchor) > CLOCK_STEP else self.anchor
        stamp = SYSTEM + self.steady - STEADY + self.anchor + self.skew
        tick, measured = Tick(stamp, number), plant.sense(self.rig, self.rig_state)
        self.send(topics.ACCELERATION, ros_msgs.acceleration(tick, measured))
        self.send(topics.DEFLECTION, ros_msgs.deflection(tick, measured))
        self.send(topics.FORCE, ros_msgs.force(tick, measured, 0.15))
        self.rig_state, applied = plant.decide(self.rig, self.rig_state, conflict=self.conflict)
        self.send(topics.PWM_APPLIED, ros_msgs.applied(tick, applied))
        self.rig_state = plant.advance(self.rig, self.rig_state)
        end = self.steady + round(self.rig.dt * SECOND)
        while self.steady < end:
            self.steady = min(self.steady + WATCH, end)
            for name in self.alive:
                self.states[name], said = self.cores[name].on_time(self.states[name], self.when())
                self.answer(said)

    def when(self) -> When:
        """Now, on both clocks."""
        return When(self.steady, SYSTEM + self.steady - STEADY + self.jump)

    def send(self, topic: topics.Topic, message: Any) -> None:
        """Send a message of the plant to everybody, as far as faults let it through."""
        channel = self.channels.get(topic.name)
        out = [message]
        if channel is not None:
            self.channels[topic.name], out = through(channel, message, self.t, self.random)
        for each in out:
            for last in self.between(topic, each):
                self.give(topic, last)

    def give(self, topic: topics.Topic, message: Any) -> None:
        """Deliver one message."""
        self.log[topic.name].append(Heard(self.t, message))
        for name in sorted(self.alive):
            if topic in self.cores[name].inputs:
                old = self.states[name]
                self.states[name], said = self.cores[name].on_message(
                    old, topic, message, self.when()
                )
                self.answer(said)

    def answer(self, said: Sequence[tuple[topics.Topic, Any]]) -> None:
        """Messages of a core: commands reach the plant, as far as faults let them."""
        for topic, message in said:
            self.log[topic.name].append(Heard(self.t, message))
            if topic is topics.PWM_COMMAND:
                channel = self.channels[topic.name]
                self.channels[topic.name], out = through(channel, message, self.t, self.random)
                for each in out:
                    self.command(each)

    def command(self, message: Any) -> None:
        """What the plant node does with a command whose stamp is good."""
        seq, now = int(message.seq), self.rig_state.sim.tick
        at = (seq if 0 < seq <= now else now) * self.rig.dt
        command = Command(at, seq, float(message.duty), int(message.source))
        self.rig_state = plant.receive(
            self.rig, self.rig_state, command, valid=bool(message.valid)
        )
