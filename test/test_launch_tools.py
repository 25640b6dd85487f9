"""The real `ros2 launch` with our launch files, alone and taken in by a vehicle's own."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep

import pytest

pytest.importorskip("rclpy")

from test.graph_help import own_domain
from test.ros2_tools import MISSING, command, environment, prefix, tools

pytestmark = pytest.mark.alone

PARENT = """
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_ros.actions import PushRosNamespace, SetParameter, SetRemap

SYSTEM = {system!r}
GIVEN = {{"observers": "none", "duration": "0", "respawn": "true"}}


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("driver"),
        GroupAction([
            PushRosNamespace("truck"),
            SetRemap("sensors/acceleration", "/chassis/imu"),
            SetParameter("command_timeout", 0.04),
            SetParameter("wheel_base", 2.7),
            IncludeLaunchDescription(PythonLaunchDescriptionSource(SYSTEM), launch_arguments=GIVEN.items()),
        ]),
    ])
"""


class Launched:
    """A running `ros2 launch`; its lines go to a file."""

    def __init__(self, paths: list[str], env: dict[str, str], log: Path, *words: str) -> None:
        self.log = log
        with log.open("w") as out:
            self.process = subprocess.Popen(
                command(paths, "launch", *words), env=env, stdout=out, stderr=subprocess.STDOUT,
                start_new_session=True,
            )  # fmt: skip

    @property
    def text(self) -> str:
        return self.log.read_text()

    def wait_for(self, words: str, times: int = 1, seconds: float = 60.0) -> None:
        until = monotonic() + seconds
        while self.text.count(words) < times:
            assert monotonic() < until, f"no '{words}' in {seconds} s:\n{self.text}"
            assert self.process.poll() is None, f"it ended:\n{self.text}"
            sleep(0.05)

    def pid(self, label: str) -> int:
        """Process number of a node that was started last under this name."""
        return int(
            re.findall(rf"\[{label}-\d+\]: process started with pid \[(\d+)\]", self.text)[-1]
        )

    def end(self, seconds: float = 60.0) -> int:
        return self.process.wait(timeout=seconds)

    def gone(self) -> None:
        """End it, and with a kill every node that outlives it."""
        try:
            if self.process.poll() is None:
                self.process.send_signal(signal.SIGINT)
                self.end()
        finally:
            with suppress(ProcessLookupError):
                os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()


@contextmanager
def launching(folder: Path) -> Iterator[Callable[..., Launched]]:
    """Starts `ros2 launch` with these words; all of it is gone afterwards."""
    paths = tools()
    if paths is None:
        pytest.skip(MISSING)
    started: list[Launched] = []
    with own_domain() as env:
        env = environment(env, prefix(folder))

        def start(*words: str) -> Launched:
            started.append(Launched(paths, env, folder / f"{len(started)}.log", *words))
            return started[-1]

        try:
            yield start
        finally:
            for each in started:
                each.gone()


@pytest.fixture
def launch(tmp_path: Path) -> Iterator[Callable[..., Launched]]:
    with launching(tmp_path) as start:
        yield start


def four_corners(running: Launched) -> None:
    """The example of a car, driven for a second, comes to a good end."""
    assert running.end(120.0) == 0, running.text
    for corner in ("front_left", "front_right", "rear_left", "rear_right"):
        assert f"[vehicle.suspension.{corner}.plant]: finished after 200 ticks" in running.text
    assert not re.search(r"^\[ERROR\]", running.text, re.M), running.text  # launch's own
    assert running.text.count("process has finished cleanly") == 4, running.text


def test_a_vehicle_takes_the_graph_in_and_goes_on_when_a_node_is_killed(
    launch, tmp_path: Path
) -> None:
    parent = tmp_path / "truck.launch.py"
    parent.write_text(
        PARENT.format(system=str(tmp_path / "prefix/share/er_bringup/launch/system.launch.py"))
    )
    running = launch(str(parent), "driver:=x")
    running.wait_for("[truck.plant]: running")
    running.wait_for("[truck.skyhook_controller]: running")
    assert "wheel_base is no parameter of this node, left to others" in running.text
    assert "-p command_timeout:=0.04" in Path(
        f"/proc/{running.pid('plant')}/cmdline"
    ).read_text().replace("\0", " ")
    os.kill(running.pid("skyhook_controller"), signal.SIGKILL)
    running.wait_for("[skyhook_controller-1]: process started", times=2)
    running.wait_for("[truck.skyhook_controller]: running", times=2)
    assert "/chassis/imu" in running.text  # what is said of an input has its new name
    assert running.text.count("process has died") == 1
    running.process.send_signal(signal.SIGINT)
    assert running.end() == 0, running.text
    assert running.text.count("process has finished cleanly") == 2, running.text


def test_four_corners_of_a_car_come_to_a_good_end(launch) -> None:
    four_corners(launch("er_bringup", "vehicle.launch.py", "duration:=1", "observers:=none"))


def test_an_argument_that_there_is_not_is_refused(launch) -> None:
    running = launch("er_bringup", "system.launch.py", "contrller:=none")
    assert running.end() == 1
    assert "contrller: expected a known key (did you mean controller?)" in running.text
    assert "process started" not in running.text
