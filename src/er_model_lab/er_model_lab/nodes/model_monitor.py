"""The node around the monitor: its core, and beside it the service that changes the model and the action that learns.

A diagnosis is the work of a process of its own; the node only looks at it ten times a second.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
from er_common.program import Program
from er_models.errors import ErError
from er_models.model import Array
from er_ros_common.core_node import LATER, CoreNode
from er_ros_common.health import Report
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.client import Client
from rclpy.parameter import Parameter

from er_damper_msgs.action import Diagnose
from er_damper_msgs.srv import UseModel
from er_model_lab.monitor.compare import Row
from er_model_lab.monitor.learning import Learning, Task
from er_model_lab.ros_monitor import MonitorCore, State
from er_ros_common import log

FALLS_BACK = {"leave_out": True}
"""Of a model with more than a node's law holds it takes what it can."""
OBSERVER = "_observer"
"""Ends the name of a node whose gains have to be made for a model."""
PATIENCE = 3.0
"""How long other nodes are waited for [s]."""
LOOK = 0.1
"""How often the process that learns is looked at [s]."""
LEAST = 5.0
"""Time below which nothing can be learnt from what was heard [s]."""
CHANNELS = (
    "t", "sprung_acceleration", "unsprung_acceleration", "deflection", "deflection_velocity", "duty", "damper_force",
)  # fmt: skip
"""Of a row of what was heard, in order."""


class Memory:
    """What was heard last, a row a tick; rows older than its length are written over."""

    def __init__(self, length: int) -> None:
        self.rows, self.count = np.empty((length, len(Row._fields))), 0

    def add(self, rows: Sequence[Row]) -> None:
        """Keep rows; time that jumps back begins anew."""
        for row in rows:
            at = self.count % len(self.rows)
            if self.count and 1e-9 * row.stamp <= self.rows[at - 1, 0]:
                self.count = at = 0
            self.rows[at] = (1e-9 * row.stamp, *row[1:])
            self.count += 1

    def last(self, seconds: float) -> dict[str, Array]:
        """Channels (n,) of the last seconds, 0: of all that is kept; those that never came are left out."""
        at = self.count % len(self.rows)
        rows = self.rows[:at] if self.count < len(self.rows) else np.roll(self.rows, -at, axis=0)
        if seconds and len(rows):
            rows = rows[rows[:, 0] > rows[-1, 0] - seconds]
        found = dict(zip(CHANNELS, rows.T.copy(), strict=True))
        return {name: each for name, each in found.items() if np.isfinite(each).any()}


class Asked:
    """Another node that is asked to go over to a model through its parameters.

    word: what came of it, in a sentence, empty while that is not known; stays: whether it keeps its model.
    """

    def __init__(self, name: str, client: Client, model: str) -> None:
        self.name, self.word, self.stays = name, "", False
        self._client, self._until = client, monotonic() + PATIENCE
        self._values, self._answer = wanted(name, str(Path(model).absolute())), None

    def look(self) -> bool:
        """Ask it once it is found; whether it is known what came of it."""
        if self._answer is None and self._client.service_is_ready():
            each = [Parameter(k, value=v).to_parameter_msg() for k, v in self._values.items()]
            self._answer = self._client.call_async(
                SetParametersAtomically.Request(parameters=each)
            )
        if self._answer is not None and self._answer.done():
            result = self._answer.result().result
            how, self.stays = _said(result)
        elif monotonic() > self._until:
            how, self.stays = " does not answer: it keeps its model", True
        else:
            return False
        self.word = f"{self.name}{how}"
        return True


def _said(result: SetParametersResult) -> tuple[str, bool]:
    """What the answer of a node comes to, and whether its model stays."""
    if result.successful:
        return " goes over to it, too", False
    if result.reason.endswith(LATER):
        return f": {result.reason}", False
    return f" keeps its model: {result.reason}", True


def wanted(name: str, model: str) -> dict[str, Any]:
    """What the parameters of a node are to be for a model file: a plant keeps its car, an observer has gains made."""
    name = name.rpartition("/")[2]
    if name == "plant":
        return {"damper_file": model}
    gains = {"gains_file": ""} if name.endswith(OBSERVER) else {}
    return {"model_file": model, **FALLS_BACK, **gains}


class MonitorNode(CoreNode):
    """A monitor, what it has heard, and the diagnosis that is under way, if any, with the goal that asked for it."""

    core: MonitorCore
    state: State

    def __init__(self, program: Program, argv: Sequence[str] | None = None) -> None:
        super().__init__(program, argv)
        self.learning: Learning | None = None
        self.goal: ServerGoalHandle | None = None
        self.outcomes: dict[bytes, dict[str, Any]] = {}

    def configure(self) -> None:
        """The core, and what can be asked of it."""
        super().configure()
        self.memory = Memory(round(self.core.p.memory * self.core.p.rate))
        self.offer(UseModel, "~/use_model", self.on_use_model)
        self.server: ActionServer = self._once("action ~/diagnose", self._served)
        self.every(LOOK, self.on_look)
        self.every(LOOK, self.on_others)
        self.asked: list[Asked] = []
        for name in self.core.p.along:
            self._client(name)

    def _client(self, name: str) -> Client:
        service = f"{name}/set_parameters_atomically"
        made: Client = self._once(
            f"client {name}", lambda: self.create_client(SetParametersAtomically, service)
        )
        return made

    def _served(self) -> ActionServer:
        return ActionServer(
            self,
            Diagnose,
            "~/diagnose",
            execute_callback=self.finished,
            handle_accepted_callback=self.on_accepted,
            cancel_callback=self.on_cancel,
        )

    def end(self) -> None:
        """Learn no more."""
        super().end()
        if self.learning is not None:
            self.learning.stop()
            self.on_look()

    def take(self, state: Any, said: Any) -> bool:
        """Go over to a state, and keep what it has heard."""
        if state.rows is not self.state.rows:
            self.memory.add(state.rows)
        return super().take(state, said)

    def report(self) -> Report:
        """Health of the model, what other nodes said that were to go over with it, and how far a diagnosis is."""
        said, more = super().report(), dict[str, object]()
        if self.asked:
            more["along"] = "; ".join(each.word or f"{each.name} is asked" for each in self.asked)
        if self.learning is not None:
            told = self.learning.told
            more["diagnosis"] = f"{told['stage']} {told['done']:.0%} {told['best']}".strip()
        return replace(said, values={**said.values, **more})

    def on_use_model(self, request: UseModel.Request, answer: UseModel.Response) -> Any:
        """Go on with another model from the next sample on, or say why not; other nodes are asked beside the loop."""
        if not self.active:
            answer.reason = "the node is not active"
            return answer
        try:
            core = self.core.with_model(request.model)
        except ErError as error:
            answer.reason = " ".join(str(error).split())
            return answer
        self.go_over(core)
        answer.accepted, answer.reason = True, core.goes_by(self.state)
        names = dict.fromkeys((*self.core.p.along, *request.along))
        self.asked = [Asked(name, self._client(name), request.model) for name in names]
        if names:
            answer.reason += f"; asked to go over, too: {', '.join(names)}"
        return answer

    def on_others(self) -> None:
        """Go on with what other nodes are asked, and say what came of it."""
        for each in self.asked:
            if not each.word and each.look():
                (log.warning if each.stays else log.info)(self, each.word)

    def on_accepted(self, goal: ServerGoalHandle) -> None:
        """Begin to learn, or end it with the reason: a goal that ROS rejects could not say one."""
        if not self.active or self.goal is not None:
            why = "another one is under way" if self.active else "the node is not active"
            self._answer(goal, {"reason": f"refused: {why}"})
            return
        asked, p = goal.request, self.core.p
        heard = {} if asked.bag else self.memory.last(asked.seconds)
        t = heard.get("t", np.zeros(0))
        if not asked.bag and (t.size < 2 or t[-1] - t[0] < LEAST or "damper_force" not in heard):
            self._answer(goal, {"reason": f"less than {LEAST:g} s were heard with a force"})
            return
        self.goal = goal
        self.learning = Learning(Task(asked.model or p.model_file, asked.bag, p.models), heard)

    def on_cancel(self, goal: ServerGoalHandle) -> CancelResponse:
        """Stop it."""
        if self.goal is None or _id(goal) != _id(self.goal) or self.learning is None:
            return CancelResponse.REJECT
        self.learning.cancel()
        return CancelResponse.ACCEPT

    def on_look(self) -> None:
        """Say how far it is, or what came of it."""
        learning = self.learning
        if learning is None:
            return
        new = learning.look()
        if learning.result is not None:
            self.learning, goal, self.goal = None, self.goal, None
            if goal is not None:
                self._answer(goal, learning.result)
        elif new and self.goal is not None:
            self.goal.publish_feedback(Diagnose.Feedback(**learning.told))

    def _answer(self, goal: ServerGoalHandle, result: dict[str, Any]) -> None:
        self.outcomes[_id(goal)] = result
        goal.execute()

    def finished(self, goal: ServerGoalHandle) -> Diagnose.Result:
        """End a goal with what came of it."""
        outcome = self.outcomes.pop(_id(goal))
        result = Diagnose.Result(**{k: v for k, v in outcome.items() if _number(v)})
        if goal.is_cancel_requested:
            goal.canceled()
        elif outcome.get("verdict"):
            log.info(self, f"~/diagnose: {result.reason}; {result.model}")
            goal.succeed()
        else:
            log.warning(self, f"~/diagnose: {result.reason}")
            goal.abort()
        return result


def _id(goal: ServerGoalHandle) -> bytes:
    return bytes(goal.goal_id.uuid)


def _number(value: Any) -> bool:
    """Whether a message may hold it."""
    return not isinstance(value, float) or math.isfinite(value)


AROUND = MonitorNode
