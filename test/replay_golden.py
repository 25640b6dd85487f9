"""Golden answers of all cores to one simulated ride, and the reasons of their changes.

    ./er exec python -m test.replay_golden --reason "why the answers changed"

The ride is made here, with the plant, the observers and Skyhook answering one another as cores, no process
and no ROS graph between them; so it is the same everywhere, but for the last digits of a machine's arithmetic.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
from pathlib import Path
from typing import Any

import yaml
from er_bringup.cores import entry
from er_bringup.played import core_of, play
from er_bringup.programs import CORES
from er_bringup.recording import opened
from er_common.parameter_table import build as parameters_of
from er_ftc_controller.programs import SKYHOOK
from er_models.files import load_model
from er_observers.programs import OBSERVERS
from er_plant_sim.build import build
from er_plant_sim.duty_gate import Command
from er_plant_sim.settings import PlantParameters
from er_records.recording.bag_writer import BagWriter
from er_ros_common.builders import Tick
from er_ros_common.core import When
from rclpy.serialization import serialize_message

from er_common import topics
from er_plant_sim import rig as plant
from er_plant_sim import ros_msgs
from test.conftest import ROOT

CONFIG = ROOT / "config"
FILE = ROOT / "test/golden/replay.yaml"
VEHICLE = str(CONFIG / "vehicles/inove_quarter_car.yaml")
TICKS, DT = 800, 5_000_000
EVERY = 40
"""Of so many answers one is kept."""
IN_THE_LOOP = (*(program.name for program in OBSERVERS.values()), SKYHOOK.name)
NODES = (*IN_THE_LOOP, *sorted(CORES.keys() - set(IN_THE_LOOP)))


def node_parameters(name: str) -> dict[str, Any]:
    """Parameters of a node as its file in config/nodes has them."""
    file = yaml.safe_load((CONFIG / f"nodes/{name}.yaml").read_text())
    given, program = dict(file["/**"]["ros__parameters"]) | {"max_age": 0.0}, CORES[name]
    if program.model:
        given["model_file"] = VEHICLE
    if program.gains:
        given["gains_file"] = str(CONFIG / f"gains/{program.gains}.yaml")
    return given


def ride(out: Path, ticks: int = TICKS) -> Path:
    """Write a recording of plant, observers and Skyhook as cores that answer one another at once."""
    plant_file = yaml.safe_load((CONFIG / "nodes/plant.yaml").read_text())
    given = plant_file["/**"]["ros__parameters"] | {
        "model_file": VEHICLE, "program_file": str(CONFIG / "experiments/iso_steps.yaml"),
        "seed": 7, "duration": 0.0, "duty_source": "topic",
    }  # fmt: skip
    rig = build(parameters_of(PlantParameters, given, {}))
    cores = {}
    for name in IN_THE_LOOP:
        shell = entry(name)
        cores[name] = shell.make(parameters_of(shell.parameters, node_parameters(name), {}))
    states = {name: core.start() for name, core in cores.items()}
    bag = BagWriter(out)
    connections: dict[str, Any] = {}

    def write(topic: topics.Topic, message: Any, when: int) -> None:
        if topic.name not in connections:
            connections[topic.name] = bag.topic(f"/{topic.name}", topic.type_name)
        bag.write(connections[topic.name], when, serialize_message(message))

    def heard(topic: topics.Topic, message: Any, when: int) -> list[Any]:
        write(topic, message, when)
        answers = []
        for name, core in cores.items():
            if topic in core.inputs:
                states[name], said = core.on_message(
                    states[name], topic, message, When(when, None)
                )
                for to, answer in said:
                    write(to, answer, when)
                    answers.append(answer)
        return answers

    state = plant.start(rig)
    for k in range(1, ticks + 1):
        tick, measured, when = Tick(k * DT, k), plant.sense(rig, state), k * DT + 1000
        heard(topics.ACCELERATION, ros_msgs.acceleration(tick, measured), when)
        commands = heard(topics.DEFLECTION, ros_msgs.deflection(tick, measured), when)
        write(topics.FORCE, ros_msgs.force(tick, measured, 0.15), when)
        write(topics.ROAD, ros_msgs.road(tick, measured), when)
        for c in commands:
            wish = Command(plant.time(rig, state), c.seq, c.duty, c.source)
            state = plant.receive(rig, state, wish, valid=c.valid)
        state, applied = plant.decide(rig, state)
        heard(topics.PWM_APPLIED, ros_msgs.applied(tick, applied), when)
        state = plant.advance(rig, state)
        if k % 100 == 0:
            bag.flush()
    model = load_model(VEHICLE).digest()
    bag.close({
        "parameters": {f"/{name}": node_parameters(name) for name in IN_THE_LOOP},
        "models": {f"/{name}": model for name in IN_THE_LOOP if CORES[name].model},
    })  # fmt: skip
    return out


def answers(bag_path: Path) -> dict[str, list[dict[str, Any]]]:
    """Every so-many-th answer of every node to the recording, without its header."""
    bag, found = opened(bag_path), {}
    for name in NODES:
        given = {} if name in IN_THE_LOOP else node_parameters(name)
        said = play(bag, name, core_of(bag, name, "", given)).answers
        found[name] = [
            {k: getattr(m, k) for k in m.get_fields_and_field_types() if k != "header"}
            for _, m in said[:: EVERY]
        ]  # fmt: skip
    return found


def digest(values: Any) -> str:
    """What ties a reason to the values it was written for: a change of 1e-9 is one."""
    text = json.dumps(values, default=float, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def same(golden: Any, found: Any) -> bool:
    """Whether values are the same but for the last digits of another machine's arithmetic."""
    if isinstance(golden, float) or isinstance(found, float):
        return math.isclose(golden, found, rel_tol=1e-9, abs_tol=1e-9)
    return bool(golden == found)


def main() -> None:
    """Write the golden file anew, with the reason."""
    import tempfile

    p = argparse.ArgumentParser(prog="replay_golden", description=__doc__)
    p.add_argument("--reason", required=True, help="why the answers changed")
    reason = p.parse_args().reason
    with tempfile.TemporaryDirectory() as folder:
        values = answers(ride(Path(folder) / "bag"))
    values = json.loads(json.dumps(values, default=float))
    old = yaml.safe_load(FILE.read_text()) if FILE.exists() else {"reasons": []}
    reasons = [*old["reasons"], {"reason": reason, "digest": digest(values)}]
    document = {"reasons": reasons, "every": EVERY, "values": values}
    FILE.parent.mkdir(exist_ok=True)
    FILE.write_text(yaml.safe_dump(document, sort_keys=False, width=99, default_flow_style=None))


if __name__ == "__main__":
    main()
