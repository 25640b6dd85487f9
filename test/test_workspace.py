"""The checkout itself: ./er answers in one line, packages and messages are well described."""

from __future__ import annotations

import csv
import errno
import json
import os
import re
import signal
import subprocess
import sys
import time
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))

from er_workspace import commands, prerequisites, scripts  # noqa: E402
from er_workspace.layout import Layout  # noqa: E402
from er_workspace.venv import parted  # noqa: E402

PACKAGES = sorted(path.parent for path in ROOT.glob("src/*/package.xml"))
MESSAGES = sorted(ROOT.glob("src/er_damper_msgs/msg/*.msg"))
LOCK = ROOT / "requirements" / "lock.txt"

#: a field, its type, its name and the comment behind it
FIELD = re.compile(r"^(?P<type>[\w/]+)\s+(?P<name>[a-z]\w*)\s*(#\s*(?P<comment>.*))?$")
CONSTANT = re.compile(r"^uint8\s+(?P<name>[A-Z]\w*)=(?P<value>\d+)\s+#\s*\S")
UNIT = re.compile(r"\[(m|m/s|m/s2|N|s|Hz|1|-)\]")


def er(*args: str, timeout: float = 60.0) -> subprocess.CompletedProcess[str]:
    """Run ./er from another folder."""
    return subprocess.run(
        [str(ROOT / "er"), *args],
        capture_output=True,
        text=True,
        timeout=timeout,
        cwd="/",
        stdin=subprocess.DEVNULL,
        check=False,
    )


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["lba"], "er: unknown command 'lba'; did you mean lab?"),
        (["frobnicate"], "er: unknown command 'frobnicate'; known: setup, demo, test, run"),
        (["setup", "--fast"], "er: setup: unknown argument '--fast'; known: --clean, --compile"),
        (["run"], "er: run: expected PACKAGE EXECUTABLE; packages: "),
        (["run", "er_plant"], "er: run: unknown package 'er_plant'; packages: er_"),
        (["run", "er_plant_sim"], "er: run: expected EXECUTABLE; executables of er_plant_sim: "),
        (
            ["run", "er_plant_sim", "plan"],
            "er: run: er_plant_sim has no executable 'plan'; executables of er_plant_sim: ",
        ),
        (["run", "er_damper_msgs", "x"], "executables of er_damper_msgs: none"),
        (["exec"], "er: exec: expected PROGRAM [ARGS]"),
        (["exec", "no-such-program"], "er: no-such-program: No such file or directory"),
    ],
)
def test_bad_usage_is_one_line_and_status_2(args: list[str], message: str) -> None:
    done = er(*args)
    assert done.returncode == 2
    assert done.stdout == ""
    assert message in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout without anything, which the commands of this process take for theirs."""
    monkeypatch.setattr(commands, "work_root", lambda: tmp_path)
    monkeypatch.setattr(commands.prerequisites, "check", lambda: None)
    monkeypatch.setattr(commands.signal, "signal", lambda *_: None)
    monkeypatch.setenv("ER_ROS_PREFIX", str(tmp_path))
    return tmp_path


def test_a_place_that_cannot_be_written_to_is_one_line(
    elsewhere: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (elsewhere / "log").touch()
    assert commands.main(["lab", "effects"]) == 2
    assert capsys.readouterr() == ("", f"er: {elsewhere}/log: File exists\n")


def test_a_full_disk_is_one_line(
    elsewhere: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def ensure(_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(commands, "ensure", ensure)
    assert commands.main(["demo"]) == 2
    assert capsys.readouterr() == ("", f"er: {elsewhere}: No space left on device\n")


def test_ctrl_c_is_one_line_also_while_a_program_is_imported(tmp_path: Path) -> None:
    (tmp_path / "theirs.py").write_text("raise KeyboardInterrupt\n")
    (tmp_path / "slow.py").write_text("import sys\nprint(sys.argv[1:])\nimport theirs\n")
    runner = ROOT / "tools/er_workspace/program.py"
    done = subprocess.run(
        [sys.executable, runner, "slow", "a", "b"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "['a', 'b']\n", "interrupted\n")


@pytest.mark.parametrize("args", [[], ["help"], ["--help"], ["-h"]])
def test_help_names_every_command_in_one_line_each(args: list[str]) -> None:
    done = er(*args)
    assert done.returncode == 0
    rows = [line.split()[0] for line in done.stdout.splitlines() if line.startswith("  ")]
    wanted = [
        "setup",
        "demo",
        "test",
        "run",
        "up",
        "record",
        "lab",
        "doctor",
        "inject",
        "replay",
        "synth",
        "control",
        "bench",
        "study",
    ]
    assert rows == [*wanted, "exec", "help"]


@pytest.mark.alone
def test_second_setup_is_one_line_and_takes_under_3_seconds() -> None:
    er("setup", timeout=600.0)
    begin = time.monotonic()
    done = er("setup")
    assert time.monotonic() - begin < 3.0
    assert done.returncode == 0
    assert done.stdout.startswith("er: ready (")
    assert done.stdout.count("\n") == 1
    assert done.stderr == ""


@pytest.mark.parametrize(
    ("name", "quoted", "changed"),
    [
        ("plain", False, False),
        ("it's with a space", True, True),
        ("not quoted", False, True),
        ('"$HOME" said `id`', True, True),
        ("deep/" * 30, False, True),
    ],
)
def test_every_program_of_a_build_can_be_started_wherever_the_checkout_is(
    tmp_path: Path, name: str, *, quoted: bool, changed: bool
) -> None:
    layout = Layout(tmp_path / name, None)
    program = layout.install / "er_one/lib/er_one/node"
    for path in (program, layout.python):
        path.parent.mkdir(parents=True)
    layout.python.symlink_to(os.path.realpath(sys.executable))
    python = subprocess.list2cmdline([str(layout.python)]) if quoted else str(layout.python)
    text = f"#!{python}\nimport sys\nprint(sys.executable, sys.argv[1:])\n"
    program.write_text(text)
    program.chmod(0o755)
    assert scripts.unstartable(layout) == [program] * changed
    scripts.mend(layout)
    scripts.mend(layout)
    assert (program.read_text() != text) == changed
    done = subprocess.run([program, "a b", "$x"], capture_output=True, text=True, check=True)
    assert done.stdout == f"{layout.python} ['a b', '$x']\n"


def test_exit_status_and_signals_are_those_of_the_program() -> None:
    assert er("exec", "python", "-c", "raise SystemExit(7)").returncode == 7
    script = "import os, signal; print(os.getpid(), flush=True); signal.pause()"
    child = subprocess.Popen(
        [str(ROOT / "er"), "exec", "python", "-c", script], stdout=subprocess.PIPE, text=True
    )
    assert child.stdout is not None
    with child.stdout:
        # no process in between that could swallow a signal
        assert int(child.stdout.readline()) == child.pid
        child.send_signal(signal.SIGTERM)
        assert child.wait(timeout=10) == -signal.SIGTERM


@pytest.mark.parametrize("words", ["help", "up --help", "run er_plant_sim plant --help"])
def test_closed_streams_lead_nowhere(words: str) -> None:
    done = subprocess.run(
        ["bash", "-c", f"'{ROOT}/er' {words} >&- <&-"],
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_commands_see_the_messages_and_keep_ros_to_this_machine() -> None:
    script = (
        "import os, er_damper_msgs.msg, rclpy; "
        "print(os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'], os.environ.get('ROS_DOMAIN_ID'))"
    )
    assert er("exec", "python", "-c", script).stdout.split()[0] in ("LOCALHOST", "SUBNET", "OFF")
    env = {k: v for k, v in os.environ.items() if not k.startswith("ROS_")}
    command = [str(ROOT / "er"), "exec", "python", "-c", script]
    done = subprocess.run(
        command, env=env | {"ROS_DOMAIN_ID": "7"}, capture_output=True, text=True, check=True
    )
    assert done.stdout == "LOCALHOST 7\n"


def test_compiled_modules_are_kept_beside_no_source() -> None:
    script = "import er_common.stamps as s, sys; print(s.__cached__, sys.dont_write_bytecode)"
    env = {k: v for k, v in os.environ.items() if k != "PYTHONPYCACHEPREFIX"}
    done = subprocess.run(
        [str(ROOT / "er"), "exec", "python", "-c", script],
        env=env | {"PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    place, forbidden = done.stdout.rsplit(maxsplit=1)
    assert forbidden == "False"
    assert Path(place).is_relative_to(ROOT / ".venv/bytecode")
    assert Path(place).is_file()


def test_installed_python_is_the_source_itself() -> None:
    done = er("exec", "python", "-c", "import er_ros_common; print(er_ros_common.__file__)")
    found = Path(os.path.realpath(done.stdout.strip()))
    assert found == ROOT / "src/er_ros_common/er_ros_common/__init__.py"


@pytest.mark.parametrize("package", PACKAGES, ids=lambda p: p.name)
def test_every_folder_with_code_is_a_package(package: Path) -> None:
    folders = {path.parent for path in (package / package.name).rglob("*.py")}
    assert not [str(f) for f in folders if not (f / "__init__.py").is_file()]


@pytest.mark.parametrize("path", MESSAGES, ids=lambda p: p.stem)
def test_every_field_has_a_unit_and_says_when_it_is_valid(path: Path) -> None:
    fields = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        found = FIELD.match(line)
        if found:
            fields[found["name"]] = (found["type"], found["comment"] or "")
    assert {"header", "seq", "status", "valid"} <= set(fields)
    for name, (kind, comment) in fields.items():
        assert UNIT.search(comment), f"{name}: no unit in '{comment}'"
        if kind == "float64" and path.stem != "NodeStatus":
            assert "valid" in comment, f"{name}: does not say when it is valid"


@pytest.mark.parametrize("path", MESSAGES, ids=lambda p: p.stem)
def test_streams_hold_numbers_only(path: Path) -> None:
    kinds = {
        found["type"]
        for line in path.read_text(encoding="utf-8").splitlines()
        if (found := FIELD.match(line))
    }
    fixed = {"std_msgs/Header", "uint8", "uint64", "float64", "bool"}
    assert kinds <= (fixed | {"string"} if path.stem == "NodeStatus" else fixed)


def test_status_constants_are_the_same_in_every_message() -> None:
    tables = []
    for path in MESSAGES:
        found = (CONSTANT.match(line) for line in path.read_text(encoding="utf-8").splitlines())
        tables.append(
            {m["name"]: m["value"] for m in found if m and m["name"].startswith("STATUS")}
        )
    assert tables[0]
    assert all(table == tables[0] for table in tables)


def test_signs_are_written_down() -> None:
    text = {path.stem: path.read_text(encoding="utf-8") for path in MESSAGES}
    assert "positive in extension" in text["SuspensionDeflection"]
    assert "positive resists extension" in text["DamperForce"]
    assert "gravity removed" in text["SuspensionAcceleration"]
    assert "REP-145" in text["SuspensionAcceleration"]


def test_everything_asked_for_is_pinned() -> None:
    def names(path: Path) -> set[str]:
        lines = [line.split("#")[0] for line in path.read_text(encoding="utf-8").splitlines()]
        found = {re.split(r"[=<>;\s]", line.strip())[0].lower() for line in lines if line.strip()}
        return {name.replace("_", "-") for name in found}

    assert not names(ROOT / "requirements" / "base.txt") - names(LOCK)
    assert not names(LOCK) & names(ROOT / "requirements" / "jazzy.txt"), (
        "both are installed at once"
    )
    for path in (LOCK, ROOT / "requirements" / "jazzy.txt"):
        lines = path.read_text(encoding="utf-8").splitlines()
        loose = [line for line in lines if line and line[0] != "#" and "==" not in line]
        assert not loose, f"{path.name}: {loose}"
        assert "/" not in "".join(line for line in lines if not line.startswith("#"))


def test_this_python_has_what_the_lock_file_says() -> None:
    from importlib.metadata import version

    for name in ("numpy", "scipy", "numba", "setuptools", "pytest"):
        pins = re.findall(rf"^{name}==(\S+)(.*)$", LOCK.read_text(encoding="utf-8"), re.MULTILINE)
        old = sys.version_info < (3, 11)
        fitting = [pin for pin, marker in pins if not marker or ("<" in marker) is old]
        assert version(name) in fitting


def test_what_is_installed_side_by_side_has_no_file_in_common() -> None:
    """Whose file stays would be chance; packages of one part are put in order by the one pip that installs them."""
    texts = [path.read_text() for path in (LOCK, LOCK.with_name("jazzy.txt"))]
    parts = [part for text in texts for part in parted(text)]
    pins = [line for part in parts for line in part]
    assert len(parts) == 3
    assert sorted(pins) == sorted(
        line for text in texts for line in text.splitlines() if line and line[0] != "#"
    )
    place = {_plain(pin.split("==")[0]): k for k, part in enumerate(parts) for pin in part}
    owners: dict[str, set[str]] = {}
    for each in distributions(path=[str(Path(pytest.__file__).parents[1])]):
        name = _plain(each.name)
        for row in csv.reader((each.read_text("RECORD") or "").splitlines()):
            if "__pycache__" not in row[0]:
                owners.setdefault(row[0], set()).add(name)
    several = [names & set(place) for names in owners.values() if len(names) > 1]
    assert {"lark", "lark-parser"} in several
    assert [names for names in several if len({place[name] for name in names}) > 1] == []


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


@pytest.mark.parametrize(
    ("code", "said"), [("", ""), ("import sys; sys.exit('up: no gains')", "up: no gains")]
)
def test_nodes_are_compiled_unheard_and_a_failure_is_one_line(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, code: str, said: str
) -> None:
    heard: list[tuple[list[str], str]] = []
    run = subprocess.run

    def started(command: list[str], **more: Any) -> subprocess.CompletedProcess[str]:
        heard.append((command[2:], more["env"]["ROS_AUTOMATIC_DISCOVERY_RANGE"]))
        return run([sys.executable, "-c", code], **more)

    monkeypatch.setattr(subprocess, "run", started)
    monkeypatch.setattr(
        commands, "command_environment", lambda *_: {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    )
    layout = Layout(tmp_path, None)
    if said:
        with pytest.raises(commands.Stop, match=f"setup: nodes cannot be compiled: {said}"):
            commands._compile(layout)
    else:
        commands._compile(layout)
    assert {reach for _, reach in heard} == {"OFF"}
    command, *car = (words for words, _ in heard)
    assert command[0] == "er_bringup.up"
    if not said:
        assert [words[0] for words in car] == ["er_bringup.ros_composed"]
    from er_bringup.given import parse
    from er_bringup.graph import every_node, nodes
    from er_bringup.programs import CORES

    names = {spec.executable for spec in every_node(nodes(parse(command[1:]), ROOT / "config"))}
    assert names >= {*CORES} - {"skyhook_controller"} | {"plant"}


@pytest.mark.slow
@pytest.mark.alone
@pytest.mark.timeout(1800)
def test_after_compiling_no_node_compiles_at_its_start(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Of every node that runs without a device or a vehicle."""
    from test.graph_help import own_domain

    monkeypatch.setenv("ER_CACHE_DIR", str(tmp_path))
    layout = commands.find_layout(ROOT, os.environ)
    commands._compile(layout)

    def kept() -> set[str]:
        """Files of compiled code."""
        return {str(path) for path in tmp_path.rglob("*") if path.suffix == ".compiled"}

    before = kept()
    assert len(before) > 50
    beside = {
        "er_ftc_controller/skyhook_controller": "--params-file config/nodes/skyhook_controller.yaml",
        "er_bringup/ros2_control_joint": "-p model_file:=config/vehicles/inove_quarter_car.yaml",
        "er_bringup/imu_adapter": "",
        "er_bringup/joint_adapter": "",
    }
    texts = (f"{name} --ros-args -r __ns:=/front_left {more}" for name, more in beside.items())
    more = " -- ".join(texts).split()
    env = commands.command_environment(layout, os.environ)
    again = (
        ["er_bringup.up", "fault_estimator:=true", "model_monitor:=true", "duration:=2"],
        ["er_bringup.ros_composed", *commands.WARM_UP_CAR, "--", *more],
    )
    with own_domain() as own:
        for words in again:
            done = subprocess.run(
                [sys.executable, commands.PROGRAM, *words], env={**env, **own}, cwd=ROOT,
                capture_output=True, text=True, check=False,
            )  # fmt: skip
            assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    assert kept() - before == set()


def test_containers_and_workflows_call_what_there_is() -> None:
    """No container runs here: what they name must be there, and the tools be those that `./er` asks for."""
    docker = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    stages = re.findall(r"^FROM (\S+) AS (\w+)$", docker, re.M)
    assert stages == [("ros:jazzy", "base"), ("base", "product")]
    for package in (*prerequisites.TOOLS.values(), "python3-venv", "python3-dev"):
        assert re.search(rf"\b{re.escape(package)}(\s|$)", docker), package
    assert "./er setup --compile" in docker
    device = json.loads((ROOT / ".devcontainer/devcontainer.json").read_text(encoding="utf-8"))
    assert device["build"]["target"] in [name for _, name in stages]
    assert (
        ROOT / ".devcontainer" / device["build"]["dockerfile"]
    ).resolve() == ROOT / "Dockerfile"
    jobs = yaml.safe_load((ROOT / ".github/workflows/test.yml").read_text(encoding="utf-8"))[
        "jobs"
    ]
    docs = [str(step.get("run")) for step in jobs.pop("docs")["steps"]]
    assert "./er exec python tools/docs_site.py site" in docs
    assert len(jobs) == 2
    for job in jobs.values():
        assert job["steps"][-1]["run"].endswith("./er test $WHICH")  # every night: --all
