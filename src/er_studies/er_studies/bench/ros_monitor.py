"""What a model beside the damper costs: its own work, the process, and whether its answers are in time.

    er bench monitor                     the core, then the graph with each of what runs beside it for 60 s
    er bench monitor --seconds 0         the core alone

The core is given the messages of a rough road one after another; its time is that of the thread, and the same messages
go to the Skyhook controller's core: the plain loop. What runs beside the graph is in `ros_beside`. A prediction is late
where it is ready after the next sample was due. Exit status 1 where, with the monitor alone, more than 1 in 1000 are
beyond those for which the controller was late, too, where the live page takes too much of a core, or where the loop
waits longer beside it than beside programs that are busy with nothing.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from time import thread_time_ns
from typing import Any

import numpy as np
from er_bringup.up import configuration
from er_common.topics import ACCELERATION, DEFLECTION, FORCE, PWM_APPLIED, Topic
from er_ftc_controller.ros_skyhook import SkyhookCore, SkyhookParameters
from er_model_lab.monitor.settings import MonitorParameters
from er_model_lab.programs import MONITOR
from er_model_lab.ros_monitor import MonitorCore
from er_models.errors import ErError
from er_models.files import load_model
from er_models.model import Model
from er_models.one_line import OneLine
from er_models.program import load_program, resolve
from er_models.simulation import simulate
from er_ros_common.core import Core, When

from er_ros_common import builders
from er_studies.bench import ros_beside as beside
from er_studies.bench.machine import machine
from er_studies.bench.ros_beside import LIVE, PAGE, Phase
from er_studies.given_out import Table, markdown, say

DT = 0.005
LATE, SHARE, LONGER = 1e-3, 15.0, 1.3
"""Most predictions that may be late, as a share; most of a core that the live page may take [%]; and the loop's p99
beside page and browser, over that beside busy loops."""
Sent = list[tuple[Topic, Any]]


@dataclass(frozen=True)
class Cost:
    """Time of the thread per sample of a core: mean, p50, p95, p99 [us]."""

    name: str
    mean: float
    p50: float
    p95: float
    p99: float

    @property
    def share(self) -> float:
        """Of a core of the machine, at the rate of the samples [%]."""
        return 1e-4 * self.mean / DT


def ride(model: Model, seconds: float) -> list[Sent]:
    """The messages of each tick of a rough road."""
    program = load_program(configuration() / "experiments/identification.yaml")
    way, duty = resolve(program, model, DT).ride(DT)
    found = simulate(model, DT, way, duty)
    rows = min(round(seconds / DT), duty.size)
    columns = {name: found[name][:rows].tolist() for name in (
        "sprung_acceleration", "unsprung_acceleration", "deflection", "deflection_velocity", "duty", "damper_force",
    )}  # fmt: skip
    return [_tick(k, *row) for k, row in enumerate(zip(*columns.values(), strict=True), 1)]


def _tick(k: int, body: float, wheel: float, x: float, v: float, u: float, f: float) -> Sent:
    at = builders.Tick(k * 5_000_000, k)
    return [
        (ACCELERATION, builders.suspension_acceleration(at, body, wheel)),
        (DEFLECTION, builders.suspension_deflection(at, x, v)),
        (PWM_APPLIED, builders.pwm_duty(at, u)),
        (FORCE, builders.damper_force(at, f)),
    ]


def cost(name: str, core: Core, sent: Sequence[Sent]) -> Cost:
    """What a core takes for each tick; the first tenth does not count."""
    state, took = core.start(), np.empty(len(sent))
    for k, messages in enumerate(sent):
        when = When((k + 1) * 5_000_000, None)
        mine = [each for each in messages if each[0] in core.inputs]
        began = thread_time_ns()
        for topic, message in mine:
            state, _ = core.on_message(state, topic, message, when)
        took[k] = 1e-3 * (thread_time_ns() - began)
    took = took[len(sent) // 10 :]
    return Cost(name, float(took.mean()), *map(float, np.percentile(took, (50.0, 95.0, 99.0))))


def cores(seconds: float) -> list[Cost]:
    """The monitor, and the plain loop."""
    file = configuration() / "vehicles/inove_quarter_car.yaml"
    sent = ride(load_model(file), seconds)
    skyhook = SkyhookParameters(
        u_min=0.0, u_max=0.3, safe_duty=0.1, corner_frequency=0.1, max_age=0.0
    )
    monitor = MonitorParameters(model_file=str(file), max_age=0.0)
    return [
        cost("monitor", MonitorCore(monitor), sent),
        cost("skyhook controller", SkyhookCore(skyhook), sent),
    ]


def tables(found: Sequence[Cost], phases: dict[str, Phase]) -> list[Table]:
    """The figures; the plain loop's core is the last one found."""
    head = [
        "core",
        "us a sample",
        "p50",
        "p95",
        "p99",
        "% of a core at 200 Hz",
        "over the last one",
    ]
    rows = []
    for c in found:
        times = [f"{t:.0f}" for t in (c.mean, c.p50, c.p95, c.p99)]
        rows.append([c.name, *times, f"{c.share:.1f}", f"{c.mean / found[-1].mean:.1f}"])
    return [Table(head, rows), machine(), *(beside.tables(phases) if phases else [])]


def missed(phases: dict[str, Phase]) -> bool:
    """Whether more predictions are late than answers of the controller, or the live page costs too much."""
    if not phases:
        return False
    page, watching = phases[PAGE], phases[MONITOR.name]
    late = watching.late - watching.late_loop > LATE
    return late or page.parts[LIVE] > SHARE or beside.ratio(page, phases[beside.BUSY]) > LONGER


def main() -> None:
    """Entry point of the command."""
    p = OneLine(prog="er bench monitor", description=(__doc__ or "").split("\n")[0])
    p.add_argument(
        "--seconds",
        type=float,
        default=60.0,
        help="time with each of what runs beside the graph (60); 0: none",
    )
    o = p.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["ROS_LOG_DIR"] = folder
        try:
            found = cores(20.0)
            phases = beside.measured(o.seconds) if o.seconds else {}
        except ErError as error:
            sys.stderr.write(f"er bench monitor: {error}\n")
            sys.exit(error.exit_status)
    say("\n".join(map(markdown, tables(found, phases))))
    sys.exit(1 if missed(phases) else 0)


if __name__ == "__main__":
    main()
