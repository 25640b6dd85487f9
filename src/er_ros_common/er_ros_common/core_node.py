"""The node around any core: gives messages and the time to it, and publishes what it says."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from importlib import import_module
from time import perf_counter
from typing import Any

from er_common.common_parameters import deaf_after
from er_common.program import Program
from er_common.topics import Topic
from er_models.constants import SAMPLE_TIME

from er_common import topics
from er_ros_common import log
from er_ros_common.core import Core, Said, shell_of
from er_ros_common.graph_check import connected
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.managed import ManagedNode
from er_ros_common.parameters import declare
from er_ros_common.spin import Executable, run

LATER = "it goes over when they are proved"
"""Ends the refusal of parameters that a node still makes the gains for, and goes over to by itself."""


class CoreNode(ManagedNode):
    """A program that is a core.

    p is a `FramedParameters` and holds ``listeners``: how many of each output there must be before the node is ready.
    """

    core: Core
    state: Any

    def __init__(self, program: Program, argv: Sequence[str] | None = None) -> None:
        super().__init__(program.name, argv)
        self.shell = shell_of(program)
        self.p = declare(self, self.shell.parameters, self.changed)

    def configure(self) -> None:
        """Make the core and the ends of its topics."""
        shell, self.core = self.shell, self.shell.make(self.p)
        self.health.model_id, self.health.gains_id = self.core.model_id, self.core.gains_id
        self.ends = {topic.name: self.advertise(topic) for topic in self.core.outputs}
        rate = getattr(self.core.p, "rate", 0.0)  # not every core is made for one
        self.health.meter.deadline = 1.0 / rate if rate else SAMPLE_TIME
        self.inputs = {
            topic.name: self.subscribe(
                topic,
                partial(self.on_message, topic),
                shell.asked,
                needed=topic not in self.core.optional,
                whole=topic in shell.whole,
                limits=limits,
                rate=rate,
            )
            for topic, limits in zip(self.core.inputs, self.core.limits, strict=True)
        }
        _watch(self)
        self.note()

    def tune(self, p: Any) -> None:
        """Go on with other parameters from the next sample."""
        self.go_over(self.core.tuned(p))

    def go_over(self, core: Core) -> None:
        """Go on with another core of the same inputs from the next sample; another model is said in the log."""
        before, self.core = self.core, core
        if self.active:
            self.state = core.taken_over(self.state, before)
        _watch(self)
        for topic, limits in zip(core.inputs, core.limits, strict=True):
            self.incoming[topic.name].limits = limits
        self.health.model_id, self.health.gains_id = core.model_id, core.gains_id
        if (core.model_id, core.gains_id) != (before.model_id, before.gains_id):
            self.note()
            if self.active:
                log.info(self, f"model: {core.goes_by(self.state)}")

    def note(self) -> None:
        """Say what is said once of a core."""
        for topic, message in self.core.notes():
            self.advertise(topic).publish(message)

    def begin(self) -> None:
        """Know nothing yet."""
        self.state = self.core.start()

    def end(self) -> None:
        """Leave behind what the core does."""
        self.publish(self.core.last_words(self.state, self.when()))

    def on_message(self, topic: Topic, message: Any) -> None:
        """Take a message of an input."""
        began = perf_counter()
        if self.take(*self.core.on_message(self.state, topic, message, self.came)):
            self.health.meter.step(perf_counter() - began)

    def on_watch(self) -> None:
        """Go on where the inputs are silent."""
        self.take(*self.core.on_time(self.state, self.when()))

    def take(self, state: Any, said: list[Said]) -> bool:
        """Go over to a state, and publish what was said on the way; whether anything was."""
        before, self.state = self.state, state
        if not said:
            return False
        self.publish(said)
        if self.core.urgent(before, state):
            self.health.publish_status()
        return True

    def publish(self, said: Sequence[Said]) -> None:
        """Publish messages of the core."""
        for topic, message in said:
            message.header.frame_id = self.p.frame_id
            self.ends[topic.name].publish(message)

    def report(self) -> Report:
        """Health of the core; before it has heard anything, whether it is connected."""
        said = self.core.report(self.state)
        if said.mode:
            return said
        mode, reason = self.before_samples()
        return replace(said, mode=mode, reason=reason)

    def before_samples(self) -> tuple[str, str]:
        """Mode and reason of a node that has not heard anything yet."""
        optional = {topic.name for topic in self.core.optional}
        inputs = [each for name, each in self.inputs.items() if name not in optional]
        outputs = [(each, self.p.listeners) for each in self.ends.values()]
        if connected(inputs, outputs):
            return "ready", "no sample yet"
        return "waiting", "not connected yet"


def _watch(node: CoreNode) -> None:
    """Look at the silence of the inputs, no sooner than there is something to say."""
    patience = min(node.shell.patience, deaf_after(node.core.p))
    node.watch_every(node.shell.period, node.on_watch, patience)


def node_of(program: Program) -> Executable:
    """The node of a program that is a core."""
    shell = shell_of(program)
    says = (*shell.says, topics.STATUS, topics.DIAGNOSTICS)
    card = Card(program, shell.parameters, shell.hears, says)
    kind = import_module(shell.around).AROUND if shell.around else CoreNode
    return Executable(partial(kind, program), card)


def main(program: Program) -> None:
    """Run it as the program of this process."""
    node = node_of(program)
    sys.exit(run(node.make, node.card))
