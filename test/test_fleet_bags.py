"""A fleet from bags that hold several dampers at once: each namespace is a unit."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy")

import pyarrow.parquet as pq
from er_records.recording.bag_writer import BagWriter
from er_ros_common.builders import Tick
from rclpy.serialization import serialize_message

import er_model_lab as lab
from er_ros_common import builders
from test.sample import write_sample

TICK = 5_000_000
START = 1_700_000_000_000_000_000
DAMPING = {"/car/front_left": 1.0, "/car/rear": 1.5}
"""Viscous damping of each corner, of the shipped damper's."""


def drive(place: Path, day: int) -> Path:
    """A bag of both corners, one drive of five seconds."""
    bag = BagWriter(place / f"drive_{day}", "mcap")
    for corner, (namespace, share) in enumerate(DAMPING.items()):
        truth = lab.load_model("inove_guo")
        passive = truth.effects["passive"]
        truth = truth.with_effect("passive", {**passive, "c0": share * passive["c0"]})
        table = place / "samples.csv"
        write_sample(table, seed=10 * day + corner, seconds=5.0, truth=truth)
        columns = np.genfromtxt(table, delimiter=",", names=True)
        table.unlink()
        topics = {
            name: bag.topic(f"{namespace}/{name}", f"er_damper_msgs/msg/{kind}")
            for name, kind in (
                ("sensors/deflection", "SuspensionDeflection"),
                ("sensors/force", "DamperForce"),
                ("pwm/applied", "PwmDuty"),
            )
        }
        for k, row in enumerate(columns):
            tick = Tick(START + day * 3600 * 10**9 + k * TICK, k + 1)
            for name, message in (
                ("sensors/deflection", builders.suspension_deflection(
                    tick, float(row["deflection"]), float(row["deflection_velocity"]))),
                ("sensors/force", builders.damper_force(tick, float(row["damper_force"]))),
                ("pwm/applied", builders.pwm_duty(tick, float(row["duty"]))),
            ):  # fmt: skip
                bag.write(topics[name], tick.stamp, serialize_message(message))
    bag.close({})
    return place / f"drive_{day}"


@pytest.mark.slow
def test_each_namespace_of_a_bag_is_a_unit(tmp_path: Path) -> None:
    (tmp_path / "bags").mkdir()
    for day in (0, 1):
        drive(tmp_path / "bags", day)
    found = lab.fleet(
        tmp_path / "bags", lab.load_model("inove_guo"), out=tmp_path / "fleet.parquet", by="namespace",
        search=False, workers=1,
    )  # fmt: skip
    rows = {r["unit"]: r for r in pq.read_table(found.table).to_pylist()}
    assert set(rows) == {"car/front_left", "car/rear"}
    assert [r["recordings"] for r in rows.values()] == [2, 2]
    ratio = rows["car/rear"]["passive.c0"] / rows["car/front_left"]["passive.c0"]
    assert ratio == pytest.approx(1.5, rel=0.1)
    parts = pq.read_table(found.recordings_table).to_pylist()
    assert sorted((p["unit"], Path(p["path"]).name, p["status"]) for p in parts) == [
        (unit, f"drive_{day}", "used") for unit in ("car/front_left", "car/rear") for day in (0, 1)
    ]
