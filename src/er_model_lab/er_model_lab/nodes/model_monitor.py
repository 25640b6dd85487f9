"""The node around the monitor: its core, and beside it the service that changes the model and the action that learns.

A diagnosis is the work of a process of its own; the node only looks at it ten times a second.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from er_common.program import Program
from er_models.errors import ErError
from er_models.model import Array
from er_ros_common.core_node import CoreNode
from er_ros_common.health import Report
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.client import Client
from rclpy.parameter import Parameter

from er_damper_msgs.action import Diagnose
from er_damper_msgs.srv import UseModel
from er_model_lab.monitor.compare import Row
from er_model_lab.monitor.learning import Learning, Task
from er_model_lab.ros_monitor import MonitorCore, State
from er_ros_common import log

MODEL_FILE, FILE = "model_file", {"plant": "damper_file"}
"""Parameter that names a node's model; of those where it has another name. A plant keeps its car."""
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


class MonitorNode(CoreNode):
    """A monitor, what it has heard, and the diagnosis that is under way, if any, with the goal that asked for it."""

    core: MonitorCore
    state: State

    def __init__(self, program: Program, argv: Sequence[str] | None = None) -> None:
        super().__init__(program, argv)
        self.learning: Learning | None = None
        self.goal: ServerGoalHandle | None = None
        self.outcome: dict[str, Any] = {}

    def configure(self) -> None:
        """The core, and what can be asked of it."""
        super().configure()
        self.memory = Memory(round(self.core.p.memory * self.core.p.rate))
        self.offer(UseModel, "~/use_model", self.on_use_model)
        self.server: ActionServer = self._once("action ~/diagnose", self._served)
        self.every(LOOK, self.on_look)
        self.others = {name: self._client(name) for name in self.core.p.along}

    def _client(self, name: str) -> Client:
        service = f"{name}/set_parameters"
        made: Client = self._once(
            f"client {name}", lambda: self.create_client(SetParameters, service)
        )
        return made

    def _served(self) -> ActionServer:
        return ActionServer(
            self,
            Diagnose,
            "~/diagnose",
            execute_callback=self.finished,
            goal_callback=self.on_goal,
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
        """Health of the model, and how far a diagnosis is."""
        said = super().report()
        if self.learning is None:
            return said
        told = self.learning.told
        words = f"{told['stage']} {told['done']:.0%} {told['best']}".strip()
        return replace(said, values={**said.values, "diagnosis": words})

    def on_use_model(self, request: UseModel.Request, answer: UseModel.Response) -> Any:
        """Go on with another model from the next sample on, or say why not."""
        if not self.active:
            answer.reason = "the node is not active"
            return answer
        try:
            core = self.core.with_model(request.model)
        except ErError as error:
            answer.reason = " ".join(str(error).split())
            return answer
        self.state, self.core = core.taken_over(self.state), core
        self.health.model_id = core.model_id
        answer.accepted = True
        answer.reason = (
            f"{core.model.name} ({request.model}) from sample {self.state.last.seq + 1} on"
        )
        log.info(self, f"model: {answer.reason}")
        for name, asked in self.others.items():
            self._tell(name, asked, request.model)
        return answer

    def _tell(self, name: str, asked: Client, model: str) -> None:
        """Ask another node to go over to a model, through its parameters, and say what came of it."""
        if not asked.service_is_ready():
            log.warning(self, f"{name} does not answer: it keeps its model")
            return
        value = Parameter(FILE.get(name.rpartition("/")[2], MODEL_FILE), value=model)
        future = asked.call_async(SetParameters.Request(parameters=[value.to_parameter_msg()]))
        future.add_done_callback(lambda done: self._went(name, done.result().results[0]))

    def _went(self, name: str, result: SetParametersResult) -> None:
        if result.successful:
            log.info(self, f"{name} goes over to it, too")
        else:
            log.warning(self, f"{name} keeps its model: {result.reason}")

    def on_goal(self, _: Diagnose.Goal) -> GoalResponse:
        """Take a goal where none is under way."""
        if self.active and self.goal is None:
            return GoalResponse.ACCEPT
        why = "another one is under way" if self.active else "the node is not active"
        log.warning(self, f"~/diagnose is refused: {why}")
        return GoalResponse.REJECT

    def on_accepted(self, goal: ServerGoalHandle) -> None:
        """Begin to learn."""
        asked, p = goal.request, self.core.p
        heard = {} if asked.bag else self.memory.last(asked.seconds)
        self.goal = goal
        t = heard.get("t", np.zeros(0))
        if not asked.bag and (t.size < 2 or t[-1] - t[0] < LEAST or "damper_force" not in heard):
            self._answer({"reason": f"less than {LEAST:g} s were heard with a force"})
            return
        self.learning = Learning(Task(asked.model or p.model_file, asked.bag, p.models), heard)

    def on_cancel(self, _: ServerGoalHandle) -> CancelResponse:
        """Stop it."""
        if self.learning is not None:
            self.learning.cancel()
        return CancelResponse.ACCEPT

    def on_look(self) -> None:
        """Say how far it is, or what came of it."""
        learning = self.learning
        if learning is None:
            return
        new = learning.look()
        if learning.result is not None:
            self.learning = None
            self._answer(learning.result)
        elif new and self.goal is not None:
            self.goal.publish_feedback(Diagnose.Feedback(**learning.told))

    def _answer(self, result: dict[str, Any]) -> None:
        self.outcome = result
        goal, self.goal = self.goal, None
        if goal is not None:
            goal.execute()

    def finished(self, goal: ServerGoalHandle) -> Diagnose.Result:
        """End a goal with what came of it."""
        result = Diagnose.Result(**{k: v for k, v in self.outcome.items() if _number(v)})
        if goal.is_cancel_requested:
            goal.canceled()
        elif self.outcome.get("verdict"):
            log.info(self, f"~/diagnose: {result.reason}; {result.model}")
            goal.succeed()
        else:
            log.warning(self, f"~/diagnose: {result.reason}")
            goal.abort()
        return result


def _number(value: Any) -> bool:
    """Whether a message may hold it."""
    return not isinstance(value, float) or math.isfinite(value)


AROUND = MonitorNode
