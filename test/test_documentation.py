"""Every command of the documentation is run as a new user would, with data of the test's own for DATA."""

import re
import shlex
import shutil
import signal
import subprocess
import time
from importlib.util import find_spec

import numpy as np
import pyarrow.parquet as parquet
import pytest

from test.conftest import ROOT
from test.graph_help import own_domain

pytestmark = pytest.mark.slow
IN_ORDER = ("tutorial.md", "my_rig.md")
"""Documents whose commands need those before them: test_tutorial and test_my_rig run them."""
DOCUMENTS = [
    ROOT / "README.md",
    *(path for path in sorted((ROOT / "docs").glob("*.md")) if path.name not in IN_ORDER),
    *sorted((ROOT / "docs/results").glob("*.md")),
]
BLOCK = re.compile(r"^```\w*\n(.*?)^```", re.M | re.S)
ELSEWHERE = {
    "test": ("test_suite", "with other tests for it to run"),
    "bench": ("test_bench_command", "shorter: as documented they measure for minutes"),
    "lab open": ("test_page_browser", "with pages that talk to it"),
    "demo": ("test_demo", "shorter, at the pace of the computer"),
    "replay": ("test_replay", "with a recording"),
    "study classes": ("test_observer_peers", "one class, one case"),
    "study tune_peers": ("test_observer_peers", "fewer trials of one peer"),
    "study thesis chapter1": ("test_thesis_chapter_1", "which computes the chapter once"),
    "study thesis chapter2": ("test_thesis_chapter_2", "with a shorter ride"),
    "study thesis chapter6": ("test_thesis_chapter_6", "the very words"),
    "control compare thesis_6_4_1 --fault leakage": ("test_control_command", "the very words"),
    "exec python -m test.blind_score.alarms": ("test_blind_alarms", "the very words"),
    "exec python -m test.blind_score.limit": ("test_blind_limit", "with a shorter record"),
    "exec python -m test.fleet_score": ("test_fleet_truth", "fewer fleets"),
    "exec python -m test.blind_score --kinds singles": (
        "test_blind_score",
        "other seeds, lengths",
    ),
}
"""Beginnings of commands that another test runs: which, and how."""
NEEDS = {"autoware_adapter": "autoware_vehicle_msgs", "dynamic_joint_adapter": "control_msgs"}
"""Programs that need messages that no registry of Python packages has."""
DOWNLOADED = ROOT.parent / "shared" / "data"
"""Measured data of others; those who have none of them skip what needs them."""
SETS = ("mr_damper_mts", "mr_damper_shaking_table", "piston_seal_friction")
MEASURED = ("mts", "shaking", "piston")
"""Folders that a documented command makes from measured data."""
EVERY, LONGEST = 48, 1000
"""One measured run in so many is kept, and so many samples of it: what all of them give is for test_measured."""
ENDLESS = ("run", "record", "up")
"""Commands that may go on until Ctrl-C: they get one after a while and must then end well."""
STARTED = re.compile(r"running|recording|waiting")
"""What one of them says first once it is there; the rest of a graph gets `REST` more."""
REST = 1.0
PATIENCE = 7.0
"""The longest that an endless command goes on [s]."""
DRIVEN, START = "plant]: running", 60.0
"""What a graph with a plant says once it moves, and how long that may take [s]; before, a recorder has nothing."""
SHORTER = {
    "lab fleet DATA --model config/dampers/inove_guo.yaml --out fleet.parquet --no-search --report fleet"
    " --json fleet.json": ("--workers", "1"),
    "control endurance --minutes 1": ("--minutes", "0.2"),
    "control car --seeds 3 --first 100": ("--seconds", "1"),
    "control robust": ("--seeds", "1"),
    "study fault_statistics --number 40 --seed 1": ("--number", "1"),
    "study fault_trials --rivals --number 12 --seed 2": ("--number", "1"),
    "study fault_trials --number 30 --seed 2": ("--number", "1"),
    "lab plan --model config/vehicles/inove_quarter_car.yaml --between gas_spring end_stop --out next.yaml"
    " --report plan": ("--duration", "10"),
    "lab plan --model config/dampers/inove_guo.yaml --reveal end_stop --vehicle"
    " config/vehicles/inove_quarter_car.yaml --data DATA --json plan.json": ("--duration", "10"),
}  # fmt: skip
"""Commands that only take longer than a test needs: the option, and what is given instead."""


def shortened(words):
    """A command with the lengths of a test."""
    for known, (option, value) in SHORTER.items():
        if words == tuple(known.split()):
            if option not in words:
                return (*words, option, value)
            place = words.index(option) + 1
            return (*words[:place], value, *words[place + 1 :])
    return words


def forgotten(words, place):
    """Take away what an earlier command recorded under the name this one records to."""
    names = [w.removeprefix("record:=") for w in words if w.startswith("record:=")]
    for name in (*names, *(words[1:2] if words[0] == "record" else ())):
        shutil.rmtree(place / name, ignore_errors=True)


def let_go(process, log, *, plant):
    """Give an endless command its Ctrl-C once it has started, if it has not ended before; plant: it starts one."""
    end = time.monotonic() + (START if plant else PATIENCE)
    while process.poll() is None and time.monotonic() < end:
        said = log.read_text(encoding="utf-8")
        if DRIVEN in said if plant else STARTED.search(said):
            end = min(end, time.monotonic() + REST)
        time.sleep(0.1)
    if process.poll() is None:
        process.send_signal(signal.SIGINT)


def elsewhere(words):
    """Whether another test runs a command."""
    return any(words[: len(known)] == known for known in map(str.split, ELSEWHERE))


def commands():
    for path in DOCUMENTS:
        for block in BLOCK.findall(path.read_text(encoding="utf-8")):
            for line in block.replace("\\\n", " ").splitlines():
                words = shlex.split(line, comments=True) if line.startswith("./er ") else ["", ""]
                if words[0] and not elsewhere(words[1:]):
                    yield pytest.param(
                        tuple(words[1:]), id=f"{path.name}: {' '.join(words[1:])[:120]}"
                    )


CASES = list({case.values[0]: case for case in commands()}.values())


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with the configuration, measurements called DATA, MORE and RIDE, and files the documents name."""
    from test.sample import write_ride, write_sample

    folder = tmp_path_factory.mktemp("user") / "repository"
    folder.mkdir()
    (folder / "config").symlink_to(ROOT / "config")
    for name, seed in (("DATA", 1), ("MORE", 2)):
        (folder / name).mkdir()
        write_sample(folder / name / "run.csv", seed=seed, seconds=14.0)
    (folder / "RIDE").mkdir()
    write_ride(folder / "RIDE" / "run.csv", seed=1, seconds=4.0)
    for name in SETS:
        (folder / name).symlink_to(DOWNLOADED / name)
    for name in ("my_damper.yaml", "better.yaml"):
        (folder / name).write_text((ROOT / "config/dampers/inove_guo.yaml").read_text())
    (folder / "next.yaml").write_text((ROOT / "config/experiments/chirp.yaml").read_text())
    return folder


def thin(imported):
    """Leave a part of the measured runs that were just imported; the models need not be good ones here."""
    for folder in {path.parent for path in imported.rglob("*.parquet")}:
        for n, path in enumerate(sorted(folder.glob("*.parquet"))):
            if n % EVERY:
                path.unlink()
            else:
                table = parquet.read_table(path)
                middle = max(table.num_rows - LONGEST, 0) // 2  # at both ends the machine rests
                parquet.write_table(table.slice(middle, LONGEST), path)


@pytest.fixture
def domain():
    """A ROS domain that no other test of this machine has."""
    with own_domain() as env:
        yield env["ROS_DOMAIN_ID"]


@pytest.mark.parametrize("words", CASES)
def test_the_command_works_as_written(words, place, domain, monkeypatch, tmp_path):
    measured = any(w.split("/")[0] in (*SETS, *MEASURED) for w in words)
    if measured and not DOWNLOADED.is_dir():
        pytest.skip(f"no measured data in {DOWNLOADED}")
    for missing in {NEEDS[w] for w in words if w in NEEDS and find_spec(NEEDS[w]) is None}:
        pytest.skip(f"no {missing} here")
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    forgotten(words, place)
    log = tmp_path / "output"
    with log.open("w") as stream:
        process = subprocess.Popen(
            [str(ROOT / "er"), *shortened(words)],
            cwd=ROOT if words[1:2] == ("python",) and words[3].startswith("test.") else place,
            stdout=stream,
            stderr=subprocess.STDOUT,
        )
    if words[0] in ENDLESS and "--help" not in words:
        plant = words[0] == "up" and not any(w.startswith("hardware:=") for w in words)
        let_go(process, log, plant=plant)
    process.wait(timeout=250)
    output = log.read_text(encoding="utf-8")
    allowed = (0, 1, 4) if words[0] in ("doctor", "record") else (0,)
    assert process.returncode in allowed, output[-3000:]
    assert "Traceback" not in output, output[-3000:]
    if words[:2] == ("study", "import"):
        thin(place / words[-1])


@pytest.mark.parametrize("command", ELSEWHERE)
def test_a_command_left_to_another_test_is_run_there(command):
    name, _ = ELSEWHERE[command]
    [path] = [p for p in ROOT.rglob(f"test/{name}.py") if ".venv" not in p.parts]
    text = path.read_text(encoding="utf-8")
    assert all(word in text for word in command.split() if word not in ("exec", "python", "-m")), (
        path
    )


@pytest.mark.parametrize("command", SHORTER)
def test_a_shortened_command_is_documented(command):
    assert tuple(command.split()) in [case.values[0] for case in CASES]


def test_the_documents_hold_commands():
    assert len(CASES) > 10
    assert np.unique([p.id for p in CASES]).size == len(CASES)
