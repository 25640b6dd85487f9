"""Every row of the fault table (docs/reliability.md), with what holds it, run so many times.

A row's tests are those of `test_reliability.py` that end with its number, and those of `ELSEWHERE`; `RUNS` hold what
takes a running graph and a while.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from xml.etree import ElementTree as ET

from test.conftest import ROOT

HERE = "test/test_reliability.py"
ROS, PLANT, RECORDS = (
    f"src/{name}/test" for name in ("er_ros_common", "er_plant_sim", "er_records")
)
BAGS = f"{RECORDS}/test_readers_rosbag.py"
SIGNALS = "test/test_graph_signals.py"
SECOND_CONTROLLER = (
    f"{SIGNALS}::test_the_plant_is_safe_without_its_controller_recovers_and_refuses_a_second_one"
)
ELSEWHERE: Mapping[str, tuple[str, ...]] = {
    "R3": (f"{ROS}/test_stuck.py",),
    "R5": ("test/test_watching.py::test_a_sensor_that_says_no_number_or_is_not_valid_is_named",),
    "R6": (
        f"{PLANT}/test_duty_gate.py::test_nothing_outside_the_range_ever_leaves",
        f"{PLANT}/test_duty_gate.py::test_limits_are_counted",
    ),
    "R7": (
        f"{PLANT}/test_commands.py::test_a_command_is_as_old_as_the_sample_it_answers",
        f"{PLANT}/test_commands.py::test_no_duty_acts_longer_than_50_ms_after_the_sample_by_stamp_alone",
    ),
    "R8": (
        f"{PLANT}/test_commands.py::test_a_bad_stamp_is_dropped_and_counted_whatever_the_number",
        f"{ROS}/test_inputs.py::test_a_bad_stamp_is_named_for_a_second",
    ),
    "R13": (
        "test/test_graph_run.py::test_latched_topics_are_recorded_although_nobody_waited_for_them",
    ),
    "R14": (
        "test/test_watching.py::test_a_qos_that_carries_nothing_is_named",
        "test/test_graph_doctor.py::test_faults_of_a_running_graph_are_named",
    ),
    "R15": (
        f"{ROS}/test_graph_check.py::test_other_types_are_found_on_both_ends",
        "test/test_watching.py::test_another_type_on_a_topic_is_named",
    ),
    "R16": (
        f"{ROS}/test_inputs.py::test_silence_is_a_warning_after_one_second_and_an_error_after_five",
        "test/test_watching.py::test_a_missing_input_and_a_stamp_that_is_not_set_are_named",
    ),
    "R17": ("test/test_watching.py::test_a_second_controller_is_named", SECOND_CONTROLLER),
    "R18": (SECOND_CONTROLLER,),
    "R19": (
        f"{SIGNALS}::test_nodes_end_on_ctrl_c_without_a_traceback",
        f"{SIGNALS}::test_recordings_are_closed_whatever_the_signal",
        f"{ROS}/test_spin.py::test_signal_ends_a_node_cleanly",
        f"{ROS}/test_spin.py::test_a_signal_ends_a_program_whose_node_is_still_being_made",
        "test/test_managed.py::test_a_program_that_is_still_being_imported_ends_quietly",
    ),
    "R21": (
        "src/er_common/test/test_parameter_table.py",
        f"{ROS}/test_parameter_files.py",
        f"{ROS}/test_parameter_reader.py",
        "test/test_graph_errors.py::test_the_plant_refuses",
        "test/test_graph_errors.py::test_a_parameter_file_for_a_misspelt_node_is_not_ignored",
    ),
    "R22": (f"{ROS}/test_spin.py::test_only_dynamic_parameters_change_and_never_to_nonsense",),
    "R23": (
        "test/test_graph_errors.py::test_gains_for_another_model_are_refused",
        "test/test_graph_errors.py::test_edited_gains_are_refused",
    ),
    "R24": (
        f"{BAGS}::test_a_truncated_mcap_is_salvaged_with_a_count",
        f"{BAGS}::test_a_zeroed_block_inside_an_mcap_costs_only_its_chunk",
        f"{BAGS}::test_a_cut_sqlite_bag_is_named_and_gives_what_it_can",
        "test/test_replay.py::test_a_recording_that_was_cut_is_played_as_far_as_it_goes",
    ),
    "R25": (
        f"{BAGS}::test_a_file_that_is_no_recording_is_named",
        f"{BAGS}::test_a_missing_or_broken_metadata_file_does_not_stop_the_reading",
        f"{BAGS}::test_other_topics_and_other_messages_are_named",
        f"{BAGS}::test_a_clock_offset_is_named_and_the_channel_dropped",
        "test/test_replay.py::test_a_recording_without_the_inputs_and_a_damaged_one",
    ),
    "R26": (f"{ROS}/test_builders.py",),
    "R28": (
        "test/test_graph_lockstep.py::test_same_seed_same_run",
        "test/test_replay.py::test_the_answers_are_golden",
    ),
}
RUNS: Mapping[str, tuple[str, ...]] = {"R20": ("hog", "5"), "R27": ("soak", "60")}
"""Rows that a run of `python -m test.reliability` holds, with how long."""


@cache
def tests_in(file: str) -> set[str]:
    """Names of the test functions of a file of ours."""
    tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    return {
        node.name
        for node in tree.body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    }


def rows() -> tuple[str, ...]:
    """Numbers of the rows of the documented table."""
    text = (ROOT / "docs/reliability.md").read_text(encoding="utf-8")
    return tuple(re.findall(r"R\d+", " ".join(re.findall(r"^\| (R[\d, R]+) \|", text, re.M))))


def tests_of(row: str) -> tuple[str, ...]:
    """Ids of the tests that hold a row."""
    number = f"_{row.lower()}_"
    own = sorted(name for name in tests_in(HERE) if number in f"{name}_")
    return (*(f"{HERE}::{name}" for name in own), *ELSEWHERE.get(row, ()))


def outcomes(report: Path) -> dict[str, Counter[str]]:
    """How often a test and its file passed, failed or were skipped, by id, of pytest's report (xunit1)."""
    found: dict[str, Counter[str]] = {}
    for case in ET.parse(report).iter("testcase"):
        kinds = {each.tag for each in case} & {"failure", "error", "skipped"}
        kind = "passed" if not kinds else "skipped" if kinds == {"skipped"} else "failed"
        file = str(case.get("file"))
        for name in (file, f"{file}::{str(case.get('name')).partition('[')[0]}"):
            found.setdefault(name, Counter())[kind] += 1
    return found


def held(ids: Iterable[str], found: Mapping[str, Counter[str]]) -> bool:
    """Whether each of these ran, and none failed; what was only skipped holds nothing."""
    counts = [found.get(each, Counter()) for each in ids]
    return all(each["passed"] and not each["failed"] for each in counts)


def once(report: Path) -> dict[str, bool]:
    """Run all that holds the rows; whether each is held."""
    ids = sorted({each for row in rows() for each in tests_of(row)})
    options = ["-q", "-p", "no:xdist", "-o", "junit_family=xunit1", f"--junitxml={report}"]
    subprocess.run([sys.executable, "-m", "pytest", *options, *ids], cwd=ROOT, check=False)
    found = outcomes(report)
    good = {row: held(tests_of(row), found) for row in rows()}
    for row, words in RUNS.items():
        command = [sys.executable, "-m", "test.reliability", *words]
        good[row] &= subprocess.run(command, cwd=ROOT, check=False).returncode == 0
    return good


def run(times: int) -> int:
    """Print how often each row was held; 1 where one was not."""
    held_in: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        for k in range(times):
            good = once(Path(folder) / f"{k}.xml")
            held_in.update(row for row, each in good.items() if each)
            missed = ", ".join(row for row, each in good.items() if not each) or "none"
            sys.stdout.write(f"round {k + 1}: rows that were not held: {missed}\n")
            sys.stdout.flush()
    sys.stdout.write("| row | tests and runs | held |\n|---|---|---|\n")
    for row in rows():
        number = len(tests_of(row)) + (row in RUNS)
        sys.stdout.write(f"| {row} | {number} | {held_in[row]} of {times} |\n")
    return int(any(held_in[row] < times for row in rows()))
