"""Running parts of the graph as processes in tests, each test in a ROS domain of its own."""

from __future__ import annotations

import fcntl
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from pathlib import Path
from time import monotonic, sleep
from types import TracebackType

from er_bringup.programs import EVERY
from er_models.cache.folder import cache_folder
from er_ros_common.entry import run

ROOT = Path(__file__).resolve().parents[1]
CONFIG = ROOT / "config"
VEHICLE = str(CONFIG / "vehicles/inove_quarter_car.yaml")
GAINS = str(CONFIG / "gains/nlpv_polytopic.yaml")
COMMANDS = {
    "inject": "er_bringup.ros_inject",
    "up": "er_bringup.up",
    "doctor": "er_bringup.doctor",
    "record": "er_model_lab.cli.record_command",
}
"""Commands of people, and their modules."""
PROGRAMS = {program.name: program for program in EVERY}
"""Every program of the packages."""
STARTS = {
    name: f"from {program.package}.executables import {name} as main; main()"
    for name, program in PROGRAMS.items()
} | {name: f"from {module} import main; main()" for name, module in COMMANDS.items()}
"""What the script of each program runs."""
NODES = {
    name: program for name, program in PROGRAMS.items() if program.core or "nodes." in program.path
}
DOMAINS = range(10, 100)
"""Of the 101 domains that are safe on every system, those that people rarely use."""


def main_of(name: str) -> Callable[[], None]:
    """What the script of a program calls, without the signals of a process of its own."""
    if name in PROGRAMS:
        return partial(run, PROGRAMS[name])
    found: Callable[[], None] = import_module(COMMANDS[name]).main
    return found


@contextmanager
def own_domain() -> Iterator[dict[str, str]]:
    """Environment with a ROS domain that no other test of this machine has at the moment."""
    folder = cache_folder() / "test_domains"
    folder.mkdir(exist_ok=True)
    for number in sorted(DOMAINS, key=lambda n: (n * 37 + os.getpid()) % len(DOMAINS)):
        with (folder / str(number)).open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                continue
            yield os.environ | {
                "ROS_DOMAIN_ID": str(number),
                "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
                "ROS_PYTHON_CHECK_FIELDS": "1",
            }
            return
    raise RuntimeError("every test domain is in use")


class Running:
    """A started program; its output goes to a file, so that no pipe fills."""

    def __init__(self, name: str, args: Sequence[str], env: Mapping[str, str], log: Path) -> None:
        self.log = log
        command = [sys.executable, "-c", STARTS[name], *args]
        with log.open("w") as file:
            self.process = subprocess.Popen(
                command, stdout=file, stderr=subprocess.STDOUT, env=dict(env)
            )

    @property
    def text(self) -> str:
        """What it has printed so far."""
        return self.log.read_text()

    def wait_for(self, words: str, seconds: float = 60.0) -> None:
        """Wait until it has printed these words; AssertionError with its output if it does not."""
        until = monotonic() + seconds
        while words not in self.text:
            assert monotonic() < until, f"no '{words}' in {seconds} s:\n{self.text}"
            assert self.process.poll() is None or words in self.text, f"it ended:\n{self.text}"
            sleep(0.02)

    def stop(self, number: int = signal.SIGINT, seconds: float = 20.0) -> int:
        """Send a signal and wait for the end; the exit status."""
        self.process.send_signal(number)
        return self.end(seconds)

    def end(self, seconds: float = 60.0) -> int:
        """Wait for the end; the exit status."""
        return self.process.wait(timeout=seconds)


class Graph:
    """Programs of one test, all stopped at its end."""

    def __init__(self, env: Mapping[str, str], folder: Path) -> None:
        self.env, self.folder = env, folder
        self.started: list[Running] = []

    def start(self, name: str, *args: str) -> Running:
        """Start a program."""
        log = self.folder / f"{len(self.started)}_{name}.log"
        self.started.append(Running(name, args, self.env, log))
        return self.started[-1]

    def run(self, name: str, *args: str, seconds: float = 60.0) -> tuple[int, str]:
        """Run a program to its end; exit status and output."""
        running = self.start(name, *args)
        return running.end(seconds), running.text

    def __enter__(self) -> Graph:
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        for running in self.started:
            if running.process.poll() is None:
                running.process.kill()
                running.process.wait()


def paced(pace: float) -> list[str]:
    """What `up` is told where the world shall not keep to real time; pace: seconds of it in a second."""
    return [] if pace == 1.0 else ["mode:=sim_time", f"rate_factor:={pace}"]


def plant_arguments(*more: str) -> list[str]:
    """Command line of a plant with the rig's noise on the identification road."""
    files = ["--params-file", str(CONFIG / "nodes/plant.yaml")]
    program = f"program_file:={CONFIG / 'experiments/iso_steps.yaml'}"
    return ["--ros-args", *files, "-p", f"model_file:={VEHICLE}", "-p", program, *more]


def skyhook_arguments(*more: str) -> list[str]:
    """Command line of a Skyhook controller."""
    file = str(CONFIG / "nodes/skyhook_controller.yaml")
    return ["--ros-args", "--params-file", file, *more]


def observer_arguments(*more: str) -> list[str]:
    """Command line of the polytopic observer."""
    files = ["-p", f"model_file:={VEHICLE}", "-p", f"gains_file:={GAINS}"]
    return ["--ros-args", *files, *more]


def emulator_arguments(link: str, *more: str) -> list[str]:
    """Command line of a device that listens at this wire."""
    given = {
        "link": link,
        "model": VEHICLE,
        "program": CONFIG / "experiments/iso_steps.yaml",
        "calibration": CONFIG / "hardware/device_emulator.yaml",
        "params": CONFIG / "nodes/plant.yaml",
    }
    return [*(word for key, value in given.items() for word in (f"--{key}", str(value))), *more]
