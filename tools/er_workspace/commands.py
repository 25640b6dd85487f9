"""The commands of ``./er``: one table, and what hands over to the program behind each."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from pathlib import Path

from er_workspace import colcon, prerequisites, suite, venv
from er_workspace.environment import command_environment
from er_workspace.layout import Layout, Stop, find_layout, work_root
from er_workspace.process import locked, say

#: what runs the module of a command
PROGRAM = str(Path(__file__).with_name("program.py"))

#: a graph of everything that compiles, in one process, as fast as it goes
WARM_UP = (
    "composed:=true",
    "controller:=ftc",
    "fault_estimator:=true",
    "model_monitor:=true",
    "mode:=lockstep",
    "rate_factor:=0",
    "duration:=1",
)
#: and a whole car with its controller, which `er up` does not start
WARM_UP_CAR = (
    *("er_plant_sim/car_plant", "--ros-args", "--params-file", "config/nodes/car_plant.yaml"),
    *("-p", "car_file:=config/cars/inove_car.yaml", "-p", "duration:=1.0"),
    *("-p", "program_file:=config/experiments/iso_steps.yaml", "--"),
    *("er_ftc_controller/body_controller", "--ros-args"),
    *("--params-file", "config/nodes/body_controller.yaml"),
    *(
        "-p",
        "car_file:=config/cars/inove_car.yaml",
        "-p",
        "gains_file:=config/gains/body_lqr.yaml",
    ),
)

#: command: (arguments, help, module it hands over to; None where there is a function below)
COMMANDS: dict[str, tuple[str, str, str | None]] = {
    "setup": (
        "[--clean] [--compile]",
        "make or repair what the other commands need; --clean starts over, --compile compiles for the nodes",
        None,
    ),
    "demo": (
        "[ARGS]",
        "the main job: find a hidden effect in a running ROS 2 graph",
        "er_bringup.demo",
    ),
    "test": ("[--all] [ARGS]", "the tests; --all: slow ones, too; arguments go to pytest", None),
    "run": ("PACKAGE EXECUTABLE [ARGS]", "start one node, as `ros2 run` does", None),
    "up": (
        "[KEY:=VALUE ...]",
        "start the whole graph, as `ros2 launch er_bringup` does",
        "er_bringup.up",
    ),
    "record": ("OUT [ARGS]", "record a bag until Ctrl-C", "er_model_lab.cli.record_command"),
    "lab": (
        "COMMAND ...",
        "model lab: compare, diagnose, add, improve, plan, ...",
        "er_model_lab.cli.app",
    ),
    "doctor": (
        "[ARGS]",
        "check the running graph: types, QoS, rates, parameters",
        "er_bringup.doctor",
    ),
    "inject": (
        "UNIT KIND [VALUE]",
        "spoil a sensor or the command of a running plant",
        "er_bringup.ros_inject",
    ),
    "replay": (
        "BAG [--node NODE ...]",
        "play a recording to the cores of its nodes and compare",
        "er_bringup.replay",
    ),
    "synth": ("[ARGS]", "compute observer and controller gains", "er_bringup.synth"),
    "control": (
        "COMMAND ...",
        "compare the controllers in closed loop, with faults",
        "er_studies.control.command",
    ),
    "bench": ("[ARGS]", "measure speed and latency", "er_studies.bench"),
    "study": (
        "COMMAND ...",
        "the thesis made again, rivals, measured data of others",
        "er_studies.study",
    ),
    "exec": ("PROGRAM [ARGS]", "any program in the workspace's environment", None),
    "help": ("", "this list", None),
}


def main(argv: Sequence[str]) -> int:
    """Run one command; returns the exit status where the program does not take over."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    _open_streams()
    name, args = (argv[0], list(argv[1:])) if argv else ("help", [])
    if name in ("-h", "--help", "help"):
        print(_help())
        return 0
    try:
        if name not in COMMANDS:
            near = get_close_matches(name, COMMANDS, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(COMMANDS)}"
            raise Stop(f"unknown command '{name}'; {hint}")
        layout = find_layout(work_root(), os.environ)
        if name == "setup":
            return _setup(layout, args)
        ensure(layout)
        if name == "test" and signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
            # a shell has its background jobs ignore it, and so would every program that a test starts and ends
            signal.signal(signal.SIGINT, signal.default_int_handler)
        if name == "test" and not _names_paths(layout, args):
            return _test(layout, args)
        _hand_over(layout, name, args)
    except Stop as error:
        say(f"er: {error}")
        return error.status
    except OSError as error:
        # of a write that found no room it is not known where
        say(f"er: {error.filename or work_root()}: {error.strerror or error}")
        return 2
    except KeyboardInterrupt:
        say("er: interrupted")
        return 130
    return 0


def _open_streams() -> None:
    """Standard streams that the caller has closed lead nowhere: else the first file opened takes the place of one."""
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            nowhere = os.open(os.devnull, os.O_RDWR)
            if nowhere != number:
                os.dup2(nowhere, number)
                os.close(nowhere)
            os.set_inheritable(number, True)
            setattr(sys, name, os.fdopen(number, mode, closefd=False))


def ensure(layout: Layout, *, clean: bool = False) -> bool:
    """Set up what is missing; returns whether there was anything to do."""
    if (
        not clean
        and not venv.broken(layout)
        and not venv.outdated(layout)
        and colcon.current(layout)
    ):
        return False
    prerequisites.use_ros_python(layout)
    prerequisites.check()
    with locked(layout.root) as lock:
        layout.log.parent.mkdir(exist_ok=True)
        layout.log.write_text("", encoding="utf-8")
        if clean or venv.broken(layout) or venv.outdated(layout):
            venv.make(layout, lock, clean=clean)
        if not colcon.current(layout):
            colcon.build(layout, lock)
    return True


def _setup(layout: Layout, args: Sequence[str]) -> int:
    unknown = [a for a in args if a not in ("--clean", "--compile")]
    if unknown:
        raise Stop(f"setup: unknown argument '{unknown[0]}'; known: --clean, --compile")
    start = time.monotonic()
    done = ensure(layout, clean="--clean" in args)
    source = f"ROS 2 at {layout.ros}" if layout.ros else "ROS 2 Jazzy from wheels"
    what = f"set up in {time.monotonic() - start:.0f} s" if done else "nothing to do"
    if "--compile" in args:
        start = time.monotonic()
        _compile(layout)
        what += f", compiled in {time.monotonic() - start:.0f} s"
    print(f"er: ready ({source}), {what}")
    return 0


def _compile(layout: Layout) -> None:
    """Have every node run for a second of simulated time, unheard by others: what it compiles is kept in the cache."""
    env = command_environment(layout, os.environ) | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}
    for words in (("er_bringup.up", *WARM_UP), ("er_bringup.ros_composed", *WARM_UP_CAR)):
        command = [str(layout.python), PROGRAM, *words]
        done = subprocess.run(
            command, env=env, cwd=layout.root, capture_output=True, text=True, check=False
        )
        if done.returncode:
            lines = done.stderr.strip().splitlines() or ["no message"]
            raise Stop(f"setup: nodes cannot be compiled: {lines[-1]}", done.returncode)


def _hand_over(layout: Layout, name: str, args: list[str]) -> None:
    """Replace this process by the command's program: signals and exit status are the program's."""
    env = command_environment(layout, os.environ)
    module = COMMANDS[name][2]
    make: dict[str, Callable[[], list[str]]] = {
        "test": lambda: [str(layout.python), "-m", "pytest", *(a for a in args if a != "--all")],
        "run": lambda: _run_command(layout, args),
        "exec": lambda: args,
    }
    command = [str(layout.python), PROGRAM, module, *args] if module else make[name]()
    if not command:
        raise Stop(f"{name}: expected {COMMANDS[name][0]}")
    if name == "test":
        os.chdir(layout.root)
        env["ROS_PYTHON_CHECK_FIELDS"] = "1"
    sys.stdout.flush()
    try:
        os.execvpe(command[0], command, env)
    except OSError as error:
        raise Stop(f"{command[0]}: {error.strerror}") from None


def _names_paths(layout: Layout, args: Sequence[str]) -> bool:
    return any((layout.root / a.split("::")[0]).exists() for a in args if not a.startswith("-"))


def _test_folders(layout: Layout) -> list[str]:
    folders = [layout.root / "test", *(package / "test" for package in layout.packages().values())]
    return [str(f.relative_to(layout.root)) for f in folders if f.is_dir()]


def _test(layout: Layout, args: list[str]) -> int:
    """Every test folder, where the arguments name no path."""
    os.chdir(layout.root)
    env = command_environment(layout, os.environ) | {"ROS_PYTHON_CHECK_FIELDS": "1"}
    return suite.whole(layout.python, args, _test_folders(layout), env)


def _run_command(layout: Layout, args: list[str]) -> list[str]:
    """Interpreter and script of a package's executable."""
    packages = {n: layout.install / n / "lib" / n for n in layout.packages()}
    if not args or args[0] not in packages:
        found = f"unknown package '{args[0]}'" if args else "expected PACKAGE EXECUTABLE"
        useful = ", ".join(n for n, p in packages.items() if _executables(p))
        raise Stop(f"run: {found}; packages: {useful}")
    there = _executables(packages[args[0]])
    if len(args) < 2 or args[1] not in there:
        found = (
            f"{args[0]} has no executable '{args[1]}'" if len(args) > 1 else "expected EXECUTABLE"
        )
        raise Stop(f"run: {found}; executables of {args[0]}: {', '.join(there) or 'none'}")
    return [str(layout.python), str(packages[args[0]] / args[1]), *args[2:]]


def _executables(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.glob("*") if p.is_file() and os.access(p, os.X_OK))


def _help() -> str:
    width = max(len(f"{n} {a}") for n, (a, _, _) in COMMANDS.items())
    rows = [f"  {f'{n} {a}':<{width}}  {text}" for n, (a, text, _) in COMMANDS.items()]
    return "\n".join(["./er COMMAND: semi-active dampers on ROS 2, and the model lab", *rows])
