"""The benchmark says what its runs were worth: ratios, aims, losses, and a machine that is too busy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

pytest.importorskip("rclpy")

from er_bringup.graph import ends_all
from er_studies.bench.graph import Load
from er_studies.bench.ros import Result, failed, markdown, parser, specs
from er_studies.bench.ros_transport import TRANSPORTS, settings

GOOD = Result(
    "composed", "events", (0.3, 0.8, 2.0, 4.0), (0.1, 0.3, 0.5, 1.0), 0, 12000,
    (Load("composed", 11.0, 230.0),), 2.0, 0.2,
)  # fmt: skip
PLAIN = replace(
    GOOD, executor="single", loop=(1.5, 6.0, 9.0, 12.0), loads=(Load("composed", 44.0, 230.0),)
)


def test_ratios_stand_beside_one_another() -> None:
    text = markdown([GOOD, PLAIN], 60.0, 200.0)
    assert "| composed | udp | 4.00 (at least 6) | 5.0 | 0 of 12000 |" in text
    assert "| composed | 0.30 of 0.4 | 0.80 of 1 |" in text
    assert "too noisy" not in text
    assert "too noisy to judge latencies: others used 40 %" in markdown(
        [replace(GOOD, others=40.0)], 60.0, 200.0
    )


@pytest.mark.parametrize(
    ("result", "bad"),
    [
        (GOOD, False),
        (replace(GOOD, lost=1), True),
        (replace(GOOD, loop=(0.3, 1.1, 2.0, 4.0)), True),
        (replace(GOOD, loads=(Load("composed", 13.0, 230.0),)), True),
        (replace(GOOD, loop=(0.3, 9.0, 9.0, 9.0), others=50.0), False),
        (replace(PLAIN, lost=50), False),
    ],
)
def test_an_aim_that_is_missed_on_a_quiet_machine_is_a_failure(result: Result, bad: bool) -> None:
    assert failed([result], 200.0) is bad


def test_a_ratio_that_is_missed_is_a_failure_where_plain_rclpy_did_all_of_the_work() -> None:
    enough = replace(PLAIN, loads=(Load("composed", 66.1, 230.0),))
    assert not failed([GOOD, enough], 200.0)
    assert failed([GOOD, PLAIN], 200.0)
    assert not failed([GOOD, PLAIN], 1000.0)
    for changes in ({"others": 40.0}, {"lost": 7}, {"transport": "shm"}):
        assert not failed([GOOD, replace(PLAIN, **changes)], 200.0), changes
    apart = replace(GOOD, layout="processes", loads=(Load("plant", 20.0, 230.0),))
    plain = replace(apart, executor="single", loads=(Load("plant", 53.0, 230.0),))
    assert failed([apart, plain], 200.0)
    assert not failed([apart, replace(plain, loads=(Load("plant", 55.0, 230.0),))], 200.0)


def test_shared_memory_is_taken_where_no_locator_is_named(tmp_path: Path) -> None:
    udp, shared = (ET.parse(settings(each, tmp_path)) for each in TRANSPORTS)
    assert [len(each.findall(".//{*}udpv4")) for each in (udp, shared)] == [1, 0]
    assert len(shared.findall(".//{*}heartbeatPeriod")) == 1
    with pytest.raises(SystemExit, match="2"):
        parser().parse_args(["--transport", "udp,tcp"])


@pytest.mark.parametrize("layout", ["processes", "composed"])
@pytest.mark.parametrize(("controller", "told"), [("skyhook", 2), ("ftc", 3)])
def test_every_node_gets_the_executor_and_who_is_made_for_one_the_rate(
    layout: str, controller: str, told: int
) -> None:
    found = specs(layout, "single", 5.0, 400.0, controller)
    words = [" ".join(spec.arguments()) for spec in found]
    assert sum(each.count("executor:='single'") for each in words) == 6
    assert sum(each.count("rate:=400.0") for each in words) == told


def test_each_of_several_corners_has_a_graph() -> None:
    found = specs("processes", "events", 5.0, 200.0, "skyhook", corners=3)
    assert len(found) == 18
    assert len({spec.label for spec in found}) == 18
    assert sum(ends_all(spec) for spec in found) == 3
